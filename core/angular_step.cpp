#include "core/angular_step.h"

#include <cmath>
#include <numbers>

namespace backsight {
namespace {

constexpr double kCellDegrees = 2.0;

}  // namespace

AngularStep::AngularStep(const Eigen::Vector3d& scanner) : covered_(scanner, kCellDegrees) {}

bool AngularStep::Sector::Holds(const Eigen::Vector3d& d) const {
  // A border's margin is wide enough for rounding, and for RangeImage to see the same.
  constexpr double kMargin = 1e-5;
  const double range = d.norm();
  const double margin = kMargin * range;
  return cos_azimuth[0] * d.y() - sin_azimuth[0] * d.x() > margin &&
         sin_azimuth[1] * d.x() - cos_azimuth[1] * d.y() > margin &&
         d.z() < cos_low * range - margin && d.z() > cos_high * range + margin;
}

AngularStep::Sector AngularStep::SectorOf(const Eigen::Vector3d& point) const {
  const double cell = covered_.PixelAngle();
  const auto [row, column] = covered_.PixelOf(point);
  Sector sector;
  for (std::size_t side = 0; side < 2; ++side) {
    const double azimuth = (column + static_cast<int>(side)) * cell - std::numbers::pi;
    sector.cos_azimuth[side] = std::cos(azimuth);
    sector.sin_azimuth[side] = std::sin(azimuth);
  }
  sector.cos_low = std::cos(row * cell);
  sector.cos_high = std::cos((row + 1) * cell);
  return sector;
}

void AngularStep::Add(const Eigen::Vector3d& point) {
  ++points_;
  const Eigen::Vector3d beam = point - covered_.origin();
  if (last_.Holds(beam) || beam.isZero(0.0)) return;
  covered_.Add(point);
  last_ = SectorOf(point);
}

void AngularStep::Add(const AngularStep& other) {
  covered_.Add(other.covered_);
  points_ += other.points_;
}

double AngularStep::Radians() const {
  if (points_ == 0) return 0.0;
  const auto cells = static_cast<double>(covered_.Measured());
  return covered_.PixelAngle() * std::sqrt(cells / static_cast<double>(points_));
}

}  // namespace backsight
