#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/range_image.h"

namespace backsight {

/// How far apart a scanner's beams were, from its points in any order: the square root of the area
/// that they cover, in azimuth times polar angle, for each of them. Exact for a grid of equal steps
/// in both angles but for what the border of the covered area adds (cells of 2 degrees); the
/// geometric mean of both steps where they differ.
class AngularStep {
 public:
  explicit AngularStep(const Eigen::Vector3d& scanner);

  /// A measured point, in the frame of the scanner's position. Time O(1).
  void Add(const Eigen::Vector3d& point);

  /// Radians; 0 without points.
  double Radians() const;

 private:
  RangeImage covered_;
  std::uint64_t points_ = 0;
};

}  // namespace backsight
