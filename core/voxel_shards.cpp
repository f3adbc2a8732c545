#include "core/voxel_shards.h"

#include <algorithm>

#include "core/error.h"

namespace backsight {
namespace {

std::size_t ShardOf(std::uint64_t key) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 60U);
}
static_assert(VoxelShards::kShards == 16, "ShardOf gives four bits");

}  // namespace

void VoxelShards::Batch::Add(const VoxelLattice& lattice, const Eigen::Vector3d& point) {
  const Eigen::Vector3i cell = lattice.Cell(point);
  const Eigen::Vector3d offset = point - lattice.Corner(cell);
  placed_.push_back({VoxelLattice::Pack(cell), {offset.x(), offset.y(), offset.z()}});
}

void VoxelShards::Batch::Sort() {
  begin_.fill(0);
  for (const Placed& placed : placed_) ++begin_[ShardOf(placed.key) + 1];
  for (std::size_t shard = 0; shard < kShards; ++shard) begin_[shard + 1] += begin_[shard];
  std::array<std::size_t, kShards + 1> next = begin_;
  sorted_.resize(placed_.size());
  for (const Placed& placed : placed_) sorted_[next[ShardOf(placed.key)]++] = placed;
}

void VoxelShards::Add(const Batch& batch, const ExecutionContext& context) {
  BACKSIGHT_CHECK(!shards_.empty(), "the voxels have been handed out");
  constexpr std::size_t kGrain = 4;  // smaller tasks cost more than they share
  const auto add = [&](std::size_t shard) {
    for (std::size_t i = batch.begin_[shard]; i < batch.begin_[shard + 1]; ++i) {
      const auto& [key, offset] = batch.sorted_[i];
      shards_[shard].Add(key, {offset[0], offset[1], offset[2]});
    }
  };
  context.ParallelFor(kShards, add, kGrain);
}

VoxelLeaves VoxelShards::Finish() {
  BACKSIGHT_CHECK(!shards_.empty(), "voxels are handed out once");
  std::size_t voxels = 0;
  for (VoxelClusterer& shard : shards_) {
    shard.Close();
    voxels += shard.size();
  }
  struct Place {
    std::uint64_t key;
    std::uint32_t shard;
    std::uint32_t voxel;
  };
  std::vector<Place> order;
  order.reserve(voxels);
  for (std::uint32_t shard = 0; shard < kShards; ++shard) {
    for (std::uint32_t voxel = 0; voxel < shards_[shard].size(); ++voxel) {
      order.push_back({shards_[shard].KeyOf(voxel), shard, voxel});
    }
  }
  std::sort(order.begin(), order.end(),
            [](const Place& a, const Place& b) { return a.key < b.key; });
  VoxelLeaves leaves;
  leaves.Reserve(voxels);
  for (const Place& place : order) {
    leaves.Add(place.key, shards_[place.shard].ClusterOf(place.voxel));
  }
  shards_.clear();
  return leaves;
}

}  // namespace backsight
