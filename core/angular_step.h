#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace backsight {

/// How far apart a scanner's beams were, from its points in any order: the square root of the area
/// that they cover, in azimuth times polar angle, for each of them. Exact for a grid of equal steps
/// in both angles but for what the border of the covered area adds (cells of 2 degrees); the
/// geometric mean of both steps where they differ.
class AngularStep {
 public:
  AngularStep();

  /// `from_scanner`: a measured point less the scanner's position. Time O(1).
  void Add(const Eigen::Vector3d& from_scanner);

  /// Radians; 0 without points.
  double Radians() const;

 private:
  std::vector<char> covered_;
  std::uint64_t cells_ = 0;
  std::uint64_t points_ = 0;
};

}  // namespace backsight
