#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "core/voxel_grid.h"

namespace backsight {

/// VoxelClusterer for several threads. Every voxel belongs to one of a fixed number of shards, by a
/// hash of its key; a shard adds its points in the order of their batches and, within a batch, in
/// that of Sort. So the result has the bits of VoxelClusterer for any number of threads.
class VoxelShards {
 public:
  static constexpr std::size_t kShards = 16;

  /// Points on their way to their shards.
  class Batch {
   public:
    void Clear() { placed_.clear(); }
    /// `point` must lie within the lattice.
    void Add(const VoxelLattice& lattice, const Eigen::Vector3d& point);
    /// Points that were added.
    std::size_t size() const { return placed_.size(); }
    /// Brings the points shard by shard, in their order; to be called when all have been added.
    void Sort();

   private:
    friend class VoxelShards;
    struct Placed {
      std::uint64_t key;
      std::array<double, 3> offset;  // from the voxel's corner, metres
    };
    std::vector<Placed> placed_;
    std::vector<Placed> sorted_;
    std::array<std::size_t, kShards + 1> begin_{};  // of each shard in sorted_
  };

  explicit VoxelShards(const VoxelLattice& lattice) : shards_(kShards, VoxelClusterer(lattice)) {}

  /// Adds a sorted batch, on all threads. Batches must be added one after another.
  void Add(const Batch& batch, const ExecutionContext& context);

  /// Sorted by key; no more batches then.
  VoxelLeaves Finish();

 private:
  std::vector<VoxelClusterer> shards_;
};

}  // namespace backsight
