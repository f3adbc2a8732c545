#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/key_slot.h"
#include "core/voxel_lattice.h"
#include "core/voxel_points.h"

namespace backsight {

/// Occupied voxels of a lattice by position: bricks of 8 x 8 x 8 cells as bit masks in a hash
/// table, so that a look-up costs a few instructions and what is near lies near. Voxels are known
/// by their places in the list of points. Memory: 4 bytes per voxel and about 220 per brick that
/// holds or touches some. Queries are thread-safe.
class VoxelIndex {
 public:
  /// Of the points' voxels, which are distinct. O(n log n).
  explicit VoxelIndex(const VoxelPoints& points);

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
  /// The nearest of the points that the index was made of, none if all are farther from `query`
  /// than `radius_m`; equal distances go to the lower voxel. `others_squared_m2` is no less than
  /// the least of the second nearest's, the radius's and that of the nearest cell that does not
  /// touch the query's own. Time O(1) for a radius of a few cells.
  std::optional<Neighbor> Nearest(const VoxelPoints& points, const Eigen::Vector3d& query,
                                  double radius_m) const;

  /// Calls `visit(voxel, squared_m2)` for those of the points that the index was made of that are
  /// closer to `query` than `radius_m`, in an order that depends on the voxels and the query's
  /// cell.
  template <class Visit>
  void VisitWithin(const VoxelPoints& points, const Eigen::Vector3d& query, double radius_m,
                   Visit visit) const;

 private:
  static constexpr int kEdge = 8;            // of a brick, cells
  static constexpr double kRounding = 1e-9;  // cells: of where a query lies
  struct Brick {
    std::array<std::uint64_t, kEdge> masks{};  // per x; bit 8 y + z
    std::array<std::uint64_t, kEdge> near{};   // the same of cells that hold or touch a voxel
    std::array<std::uint32_t, kEdge> first{};  // of the x-slice's voxels in order_
  };
  class Search;

  void MakeBricks(std::vector<std::uint64_t> keys);
  void MarkNear(const Brick& brick, const Eigen::Vector3i& at);
  Brick* BrickAt(const Eigen::Vector3i& brick) {
    return const_cast<Brick*>(std::as_const(*this).BrickAt(brick));  // NOLINT: of this very index
  }

  /// Null where no voxel lies in the brick or beside it.
  const Brick* BrickAt(const Eigen::Vector3i& brick) const {
    const std::uint64_t key = VoxelLattice::Pack(brick);
    for (std::size_t slot = KeySlot(key, slot_mask_);; slot = (slot + 1) & slot_mask_) {
      if (slots_[slot].brick == kNoBrick) return nullptr;
      if (slots_[slot].key == key) return &bricks_[slots_[slot].brick];
    }
  }
  static int FloorOf(double value) {
    const int cut = static_cast<int>(value);
    return cut > value ? cut - 1 : cut;
  }
  /// Calls `visit(voxel, bit)` for the wanted voxels of a brick's slice across x.
  template <class Visit>
  void VisitBits(const Brick& brick, int x, std::uint64_t wanted, const Visit& visit) const {
    for (std::uint64_t bits = brick.masks[static_cast<std::size_t>(x)] & wanted; bits != 0;
         bits &= bits - 1) {
      const int bit = std::countr_zero(bits);
      visit(order_[VoxelBefore(brick, x, bit)], bit);
    }
  }
  /// The cell of a bit of a slice of the brick `at`.
  static Eigen::Vector3i CellOf(const Eigen::Vector3i& at, int x, int bit) {
    return {kEdge * at.x() + x, kEdge * at.y() + (bit >> 3), kEdge * at.z() + (bit & 7)};
  }
  /// The bits from place `first` to place `last`, cut to 0 .. 7, each place `width` bits.
  static std::uint64_t Run(int first, int last, int width) {
    const int from = width * std::max(first, 0);
    const int beyond = width * (7 - std::min(last, 7));
    return (~std::uint64_t{0} << from) & (~std::uint64_t{0} >> (64 - 8 * width + beyond));
  }
  /// The bits of a slice across x for places of y and of z.
  static std::uint64_t Window(int y_first, int y_last, int z_first, int z_last) {
    const std::uint64_t row = Run(z_first, z_last, 1) & 0xFFU;
    return Run(y_first, y_last, 8) & (row * 0x0101010101010101U);
  }
  static std::uint32_t VoxelBefore(const Brick& brick, int x, int bit) {
    const std::uint64_t below = brick.masks[static_cast<std::size_t>(x)] & ((1ULL << bit) - 1U);
    return brick.first[static_cast<std::size_t>(x)] + CountBits(below);
  }
  /// std::popcount is a call on baseline x86-64.
  static std::uint32_t CountBits(std::uint64_t bits) {
    bits -= bits >> 1U & 0x5555555555555555U;
    bits = (bits & 0x3333333333333333U) + (bits >> 2U & 0x3333333333333333U);
    bits = (bits + (bits >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
    return static_cast<std::uint32_t>(bits * 0x0101010101010101U >> 56U);
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
  const Brick* own = BrickAt(at);
  if (own == nullptr || (own->near[static_cast<std::size_t>(x)] >> bit & 1U) == 0U) return;
  std::uint64_t cross = 1ULL << bit;
  if (y > 0) cross |= 1ULL << (bit - 8);
  if (y < 7) cross |= 1ULL << (bit + 8);
  if (z > 0) cross |= 1ULL << (bit - 1);
  if (z < 7) cross |= 1ULL << (bit + 1);
  const auto offer = [&](std::uint32_t voxel, int) { visit(voxel); };
  VisitBits(*own, x, cross, offer);
  if (x > 0) VisitBits(*own, x - 1, 1ULL << bit, offer);
  if (x < 7) VisitBits(*own, x + 1, 1ULL << bit, offer);
  const auto beyond = [&](int axis, int place, int in_x, int in_bit) {
    Eigen::Vector3i next = at;
    next[axis] += place == 0 ? -1 : 1;
    if (const Brick* brick = BrickAt(next); brick != nullptr) {
      VisitBits(*brick, in_x, 1ULL << in_bit, offer);
    }
  };
  const auto on_face = [](int place) { return place == 0 || place == 7; };
  if (on_face(x)) beyond(0, x, 7 - x, bit);
  if (on_face(y)) beyond(1, y, x, 8 * (7 - y) + z);
  if (on_face(z)) beyond(2, z, x, 8 * y + 7 - z);
}

template <class Visit>
void VoxelIndex::VisitWithin(const VoxelPoints& points, const Eigen::Vector3d& query,
                             double radius_m, Visit visit) const {
  if (!lattice_.Contains(query)) return;
  const Eigen::Vector3d place = (query - lattice_.origin) / lattice_.edge_m;
  const double reach = radius_m / lattice_.edge_m + kRounding;
  const auto cell = [&](double step) {
    return Eigen::Vector3i(FloorOf(place.x() + step), FloorOf(place.y() + step),
                           FloorOf(place.z() + step));
  };
  const Eigen::Vector3i first = cell(-reach);
  const Eigen::Vector3i last = cell(reach);
  const double squared_radius = radius_m * radius_m;
  const Eigen::Vector3i own = cell(0.0);
  const VoxelPoints::DistanceFrom distance(points, own, place - own.cast<double>());
  for (int bx = first.x() >> 3; bx <= last.x() >> 3; ++bx) {
    for (int by = first.y() >> 3; by <= last.y() >> 3; ++by) {
      for (int bz = first.z() >> 3; bz <= last.z() >> 3; ++bz) {
        const Brick* brick = BrickAt({bx, by, bz});
        if (brick == nullptr) continue;
        const std::uint64_t wanted = Window(first.y() - kEdge * by, last.y() - kEdge * by,
                                            first.z() - kEdge * bz, last.z() - kEdge * bz);
        const int x_last = std::min(last.x() - kEdge * bx, kEdge - 1);
        for (int x = std::max(first.x() - kEdge * bx, 0); x <= x_last; ++x) {
          VisitBits(*brick, x, wanted, [&](std::uint32_t voxel, int bit) {
            const double squared = distance.Squared(CellOf({bx, by, bz}, x, bit), voxel);
            if (squared < squared_radius) visit(voxel, squared);
          });
        }
      }
    }
  }
}

}  // namespace backsight
