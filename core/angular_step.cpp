#include "core/angular_step.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace backsight {
namespace {

using std::numbers::pi;

constexpr int kRows = 90;
constexpr int kColumns = 2 * kRows;
constexpr double kCell = pi / kRows;

}  // namespace

AngularStep::AngularStep() : covered_(static_cast<std::size_t>(kRows) * kColumns, 0) {}

void AngularStep::Add(const Eigen::Vector3d& from_scanner) {
  const double azimuth = std::atan2(from_scanner.y(), from_scanner.x()) + pi;
  const double polar = std::atan2(std::hypot(from_scanner.x(), from_scanner.y()), from_scanner.z());
  const int row = std::clamp(static_cast<int>(polar / kCell), 0, kRows - 1);
  const int column = std::clamp(static_cast<int>(azimuth / kCell), 0, kColumns - 1);
  char& covered =
      covered_[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  cells_ += covered == 0 ? 1 : 0;
  covered = 1;
  ++points_;
}

double AngularStep::Radians() const {
  if (points_ == 0) return 0.0;
  return kCell * std::sqrt(static_cast<double>(cells_) / static_cast<double>(points_));
}

}  // namespace backsight
