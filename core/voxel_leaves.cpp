#include "core/voxel_leaves.h"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

using Part = std::uint8_t;
static_assert(VoxelLeaves::kMostParts - 1 <= std::numeric_limits<Part>::max());
using Columns = std::vector<std::vector<std::uint64_t>>;

/// The part that each voxel comes from, where columns of keys are merged.
std::vector<Part> MergedOrder(const Columns& keys, std::size_t voxels) {
  using Head = std::pair<std::uint64_t, Part>;
  std::priority_queue<Head, std::vector<Head>, std::greater<>> heads;
  std::vector<std::size_t> next(keys.size(), 0);
  const auto take = [&](Part part) {
    if (next[part] < keys[part].size()) heads.emplace(keys[part][next[part]++], part);
  };
  for (std::size_t part = 0; part < keys.size(); ++part) take(static_cast<Part>(part));
  std::vector<Part> order;
  order.reserve(voxels);
  while (!heads.empty()) {
    order.push_back(heads.top().second);
    heads.pop();
    take(order.back());
  }
  return order;
}

/// What the parts have in one column, in this order.
template <class T>
std::vector<T> Merged(std::vector<std::vector<T>> columns, const std::vector<Part>& order) {
  std::vector<T> merged;
  merged.reserve(order.size());
  std::vector<std::size_t> next(columns.size(), 0);
  for (const Part part : order) merged.push_back(columns[part][next[part]++]);
  return merged;
}

}  // namespace

VoxelLeaves VoxelLeaves::Merge(std::vector<VoxelLeaves> parts) {
  BACKSIGHT_CHECK(parts.size() <= kMostParts, "too many parts");
  if (parts.empty()) return VoxelLeaves();
  VoxelLeaves leaves(parts.front().lattice());
  std::size_t voxels = 0;
  Columns keys;
  std::vector<std::vector<VoxelPoints::Places>> places;
  std::vector<std::vector<VoxelSpread>> spreads;
  for (VoxelLeaves& part : parts) {
    BACKSIGHT_CHECK(part.lattice() == leaves.lattice(), "parts are of one lattice");
    voxels += part.size();
    keys.push_back(std::move(part.means_.keys_));
    places.push_back(std::move(part.means_.places_));
    spreads.push_back(std::move(part.spreads_));
  }
  const std::vector<Part> order = MergedOrder(keys, voxels);
  leaves.means_.keys_ = Merged(std::move(keys), order);
  leaves.means_.places_ = Merged(std::move(places), order);
  leaves.spreads_ = Merged(std::move(spreads), order);
  return leaves;
}

void VoxelLeaves::Reserve(std::size_t voxels) {
  means_.Reserve(voxels);
  spreads_.reserve(voxels);
}

void VoxelLeaves::Add(std::uint64_t key, const PointCluster& cluster) {
  means_.Add(key, cluster.mean);
  spreads_.emplace_back(cluster);
}

}  // namespace backsight
