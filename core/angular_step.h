#pragma once

#include <Eigen/Core>
#include <array>
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

  /// Takes the other's points too; both must be of the same scanner.
  void Add(const AngularStep& other);

  /// Radians; 0 without points.
  double Radians() const;

 private:
  /// Directions well within a cell.
  struct Sector {
    std::array<double, 2> cos_azimuth{}, sin_azimuth{};  // of its borders
    double cos_low = -2.0, cos_high = 2.0;               // of polar angles; at first it is empty

    bool Holds(const Eigen::Vector3d& direction) const;
  };
  Sector SectorOf(const Eigen::Vector3d& point) const;

  RangeImage covered_;
  Sector last_;  // of a covered cell: beams that follow each other mostly share it
  std::uint64_t points_ = 0;
};

}  // namespace backsight
