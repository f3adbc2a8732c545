#include "core/angular_step.h"

#include <cmath>

namespace backsight {
namespace {

constexpr double kCellDegrees = 2.0;

}  // namespace

AngularStep::AngularStep(const Eigen::Vector3d& scanner) : covered_(scanner, kCellDegrees) {}

void AngularStep::Add(const Eigen::Vector3d& point) {
  covered_.Add(point);
  ++points_;
}

double AngularStep::Radians() const {
  if (points_ == 0) return 0.0;
  const auto cells = static_cast<double>(covered_.Measured());
  return covered_.PixelAngle() * std::sqrt(cells / static_cast<double>(points_));
}

}  // namespace backsight
