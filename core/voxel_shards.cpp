#include "core/voxel_shards.h"

#include <utility>

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
  std::vector<VoxelClusterer> shards = std::exchange(shards_, {});
  std::vector<VoxelLeaves> parts;
  parts.reserve(shards.size());
  for (VoxelClusterer& shard : shards) {  // whose sums are freed as soon as they are in a part
    parts.push_back(std::exchange(shard, VoxelClusterer({})).Finish());
  }
  return VoxelLeaves::Merge(std::move(parts));
}

}  // namespace backsight
