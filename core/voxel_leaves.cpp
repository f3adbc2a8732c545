#include "core/voxel_leaves.h"

namespace backsight {

void VoxelLeaves::Reserve(std::size_t voxels) {
  keys_.reserve(voxels);
  means_.reserve(voxels);
  spreads_.reserve(voxels);
}

void VoxelLeaves::Add(std::uint64_t key, const PointCluster& cluster) {
  keys_.push_back(key);
  means_.push_back(cluster.mean);
  spreads_.emplace_back(cluster);
}

void VoxelLeaves::Translate(const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& mean : means_) mean += by;
}

}  // namespace backsight
