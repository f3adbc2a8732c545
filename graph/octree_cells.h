#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/voxel_grid.h"

namespace backsight {

/// A lattice whose cells are cut into octants three times. A subcell is known by its packed key
/// (VoxelLattice::Pack of the lattice that is eight times as fine), which holds its root cell's.
struct OctreeCells {
  static constexpr int kDepth = 3;
  static constexpr std::size_t kPaths = std::size_t{1} << (3 * kDepth);
  /// Names the cell's root; ascends with x, then y, then z.
  static std::uint64_t Root(std::uint64_t subcell) {
    constexpr std::uint64_t kField = 0x1FFFFFU >> kDepth;
    return subcell >> kDepth & (kField << 42U | kField << 21U | kField);
  }
  /// The root's coordinates on its lattice.
  static Eigen::Vector3i RootCell(std::uint64_t root) {
    constexpr int kOffset = static_cast<int>(VoxelLattice::kHalfRange >> kDepth);
    return VoxelLattice::Unpack(root).array() + static_cast<int>(VoxelLattice::kHalfRange) -
           kOffset;
  }
  /// The octants from the root down to the subcell, three bits each, the largest's first.
  static std::uint32_t Path(std::uint64_t subcell) {
    constexpr std::array<std::uint32_t, 8> kSpread{0, 1, 8, 9, 64, 65, 72, 73};
    return kSpread[subcell >> 42U & 7U] << 2U | kSpread[subcell >> 21U & 7U] << 1U |
           kSpread[subcell & 7U];
  }
  /// The octant at `depth` 1 to kDepth, of a path.
  static std::uint32_t Octant(std::uint32_t path, int depth) {
    return path >> (3 * (kDepth - depth)) & 7U;
  }
};

/// A cluster by its place in a list, and the path of its subcell.
struct PathEntry {
  std::uint32_t cluster;
  std::uint32_t path;
};

}  // namespace backsight
