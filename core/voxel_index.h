#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/voxel_grid.h"

namespace backsight {

/// Occupied voxels of a lattice by position: bricks of 8 x 8 x 8 cells as bit masks in a hash
/// table, so that a look-up costs a few instructions and what is near lies near. Voxels are known
/// by their place in the list of keys. Memory: 4 bytes per voxel and about 160 per brick. Queries
/// are thread-safe.
class VoxelIndex {
 public:
  /// `keys` are distinct and packed as VoxelLattice::Pack does. O(n log n).
  VoxelIndex(const VoxelLattice& lattice, std::span<const std::uint64_t> keys);

  std::optional<std::uint32_t> Find(const Eigen::Vector3i& cell) const;

  /// Calls `visit(voxel)` for the occupied among the point's cell and the six that share a face
  /// with it.
  template <class Visit>
  void VisitAround(const Eigen::Vector3d& point, Visit visit) const;

  struct Neighbor {
    std::uint32_t voxel = 0;
    double squared_m2 = 0.0;
    double others_squared_m2 = 0.0;  ///< no other point is closer than this
  };
  /// The nearest of `points`, point i in the cell of voxel i, none if all are farther from `query`
  /// than `radius_m`; equal distances go to the lower voxel. `others_squared_m2` is the second
  /// nearest's, or the radius's where that is less. Time O(1) for a radius of a few cells.
  std::optional<Neighbor> Nearest(std::span<const Eigen::Vector3d> points,
                                  const Eigen::Vector3d& query, double radius_m) const;

 private:
  static constexpr int kEdge = 8;  // of a brick, cells
  struct Brick {
    std::array<std::uint64_t, kEdge> masks{};  // per x; bit 8 y + z
    std::array<std::uint32_t, kEdge> first{};  // of the x-slice's voxels in order_
  };
  class Search;

  /// Null where no voxel of the brick is occupied.
  const Brick* BrickAt(const Eigen::Vector3i& brick) const {
    const std::uint64_t key = VoxelLattice::Pack(brick);
    for (std::size_t slot = Slot(key);; slot = (slot + 1) & slot_mask_) {
      if (slots_[slot].brick == kNoBrick) return nullptr;
      if (slots_[slot].key == key) return &bricks_[slots_[slot].brick];
    }
  }
  std::size_t Slot(std::uint64_t key) const {
    // Fibonacci hashing; the low bits of a product are poor.
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 32U) & slot_mask_;
  }
  template <class Visit>
  void VisitBits(const Brick& brick, int x, std::uint64_t wanted, Visit& visit) const {
    for (std::uint64_t bits = brick.masks[static_cast<std::size_t>(x)] & wanted; bits != 0;
         bits &= bits - 1) {
      visit(order_[VoxelBefore(brick, x, std::countr_zero(bits))]);
    }
  }
  static std::uint32_t VoxelBefore(const Brick& brick, int x, int bit) {
    const std::uint64_t below = brick.masks[static_cast<std::size_t>(x)] & ((1ULL << bit) - 1U);
    return brick.first[static_cast<std::size_t>(x)] +
           static_cast<std::uint32_t>(std::popcount(below));
  }

  static constexpr std::uint32_t kNoBrick = ~0U;
  struct HashSlot {
    std::uint64_t key = 0;
    std::uint32_t brick = kNoBrick;
  };

  VoxelLattice lattice_;
  std::vector<Brick> bricks_;
  std::vector<std::uint32_t> order_;  // voxels, brick by brick, by x and then by bit
  std::vector<HashSlot> slots_;
  std::size_t slot_mask_ = 0;
};

inline std::optional<std::uint32_t> VoxelIndex::Find(const Eigen::Vector3i& cell) const {
  const Brick* brick = BrickAt({cell.x() >> 3, cell.y() >> 3, cell.z() >> 3});
  if (brick == nullptr) return std::nullopt;
  const int x = cell.x() & 7;
  const int bit = 8 * (cell.y() & 7) + (cell.z() & 7);
  if ((brick->masks[static_cast<std::size_t>(x)] >> bit & 1U) == 0U) return std::nullopt;
  return order_[VoxelBefore(*brick, x, bit)];
}

template <class Visit>
void VoxelIndex::VisitAround(const Eigen::Vector3d& point, Visit visit) const {
  if (!lattice_.Contains(point)) return;
  const Eigen::Vector3i cell = lattice_.Cell(point);
  const Eigen::Vector3i at(cell.x() >> 3, cell.y() >> 3, cell.z() >> 3);
  const int x = cell.x() & 7;
  const int y = cell.y() & 7;
  const int z = cell.z() & 7;
  const int bit = 8 * y + z;
  if (const Brick* own = BrickAt(at); own != nullptr) {
    std::uint64_t cross = 1ULL << bit;
    if (y > 0) cross |= 1ULL << (bit - 8);
    if (y < 7) cross |= 1ULL << (bit + 8);
    if (z > 0) cross |= 1ULL << (bit - 1);
    if (z < 7) cross |= 1ULL << (bit + 1);
    VisitBits(*own, x, cross, visit);
    if (x > 0) VisitBits(*own, x - 1, 1ULL << bit, visit);
    if (x < 7) VisitBits(*own, x + 1, 1ULL << bit, visit);
  }
  const auto beyond = [&](int axis, int place, int in_x, int in_bit) {
    Eigen::Vector3i next = at;
    next[axis] += place == 0 ? -1 : 1;
    if (const Brick* brick = BrickAt(next); brick != nullptr) {
      VisitBits(*brick, in_x, 1ULL << in_bit, visit);
    }
  };
  const auto on_face = [](int place) { return place == 0 || place == 7; };
  if (on_face(x)) beyond(0, x, 7 - x, bit);
  if (on_face(y)) beyond(1, y, x, 8 * (7 - y) + z);
  if (on_face(z)) beyond(2, z, x, 8 * y + 7 - z);
}

}  // namespace backsight
