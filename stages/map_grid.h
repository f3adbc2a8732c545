#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/morton.h"

namespace backsight {

/// The voxels of an OctoMap, as OctoMap 1.9 numbers them and to the last bit of its arithmetic:
/// 2^16 along each axis about the frame's origin. Voxels are Morton codes.
class MapGrid {
 public:
  explicit MapGrid(double resolution_m);

  double resolution_m() const { return resolution_m_; }
  /// None outside the map.
  std::optional<std::uint64_t> VoxelAt(const Eigen::Vector3f& point) const;
  Eigen::Vector3f CenterOf(std::uint64_t voxel) const;

  /// Calls `visit(voxel)` for the voxels that a beam crosses, from that of `from` up to but not
  /// with that of `to` (Amanatides and Woo 1987); for none if either lies outside the map. About 5
  /// ns per voxel.
  template <class Visit>
  void VisitBeam(const Eigen::Vector3f& from, const Eigen::Vector3f& to, Visit visit) const;

 private:
  /// A walk along a beam.
  struct Walk {
    // Distances from the beam's start to the next border along each axis, and between borders.
    std::array<double, 3> next;
    std::array<double, 3> between;
    std::array<std::uint64_t, 3> part;  // of the voxel's code
    std::array<std::uint64_t, 3> step;  // to be added to it for the next voxel, within its bits
    double length = 0.0;
  };
  Walk Begin(const Eigen::Vector3f& from, const Eigen::Vector3f& to, std::uint64_t voxel) const;
  double CenterOf(std::uint16_t place) const {
    return (static_cast<double>(static_cast<int>(place) - kMiddle) + 0.5) * resolution_m_;
  }

  static constexpr int kMiddle = 1 << (Morton::kBits - 1);

  double resolution_m_;
  double per_m_;
};

template <class Visit>
void MapGrid::VisitBeam(const Eigen::Vector3f& from, const Eigen::Vector3f& to, Visit visit) const {
  const std::optional<std::uint64_t> first = VoxelAt(from);
  const std::optional<std::uint64_t> last = VoxelAt(to);
  if (!first || !last || *first == *last) return;
  Walk walk = Begin(from, to, *first);
  std::uint64_t voxel = *first;
  do {
    visit(voxel);
    // In case of ties the later axis, as OctoMap has it.
    const std::size_t xy = walk.next[0] < walk.next[1] ? 0 : 1;
    const std::size_t axis = walk.next[xy] < walk.next[2] ? xy : 2;
    walk.part[axis] = (walk.part[axis] + walk.step[axis]) & (Morton::kAxis << axis);
    walk.next[axis] += walk.between[axis];
    voxel = walk.part[0] | walk.part[1] | walk.part[2];
    // Rounding may lead past the last voxel.
  } while (voxel != *last && !(std::min({walk.next[0], walk.next[1], walk.next[2]}) > walk.length));
}

}  // namespace backsight
