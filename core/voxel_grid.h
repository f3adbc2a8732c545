#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/point_cluster.h"
#include "core/voxel_lattice.h"
#include "core/voxel_leaves.h"

namespace backsight {

/// Gathers streamed points into voxel clusters. Sums are formed relative to the voxel's corner, so
/// nothing cancels at large coordinates. The result is in the frame of the points, depends on their
/// order only by rounding and is sorted by key. Time O(points), memory 88 bytes and 8 to 16 more
/// per occupied voxel.
class VoxelClusterer {
 public:
  explicit VoxelClusterer(const VoxelLattice& lattice) : lattice_(lattice) {}

  /// `point` must lie within the lattice (VoxelLattice::Contains).
  void Add(const Eigen::Vector3d& point) {
    const Eigen::Vector3i cell = lattice_.Cell(point);
    Add(VoxelLattice::Pack(cell), point - lattice_.Corner(cell));
  }
  /// A point of the voxel `key`, `offset` from its corner.
  void Add(std::uint64_t key, const Eigen::Vector3d& offset);

  VoxelLeaves Finish() const;

 private:
  struct Sums {
    std::uint64_t key = 0;
    double count = 0.0;
    std::array<double, 3> first{};   // sum of d = point - corner
    std::array<double, 6> second{};  // sum of d d^T: xx xy xz yy yz zz
  };

  static constexpr std::uint32_t kNone = ~0U;
  PointCluster ClusterOf(const Sums& sums) const;
  std::uint32_t VoxelOf(std::uint64_t key);
  std::size_t SlotOf(std::uint64_t key) const;
  void Grow();

  VoxelLattice lattice_;
  // Voxels by the hash of their keys; a power of two, at most half of them taken.
  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(64, kNone);
  std::vector<Sums> sums_;
  std::uint64_t last_key_ = ~std::uint64_t{0};
  std::uint32_t last_voxel_ = 0;
};

}  // namespace backsight
