#pragma once

#include <span>
#include <vector>

#include "core/point_cluster.h"
#include "core/voxel_grid.h"

namespace backsight {

/// One station's voxel clusters, wherever they are kept; a view.
class ClusterList {
 public:
  ClusterList(const std::vector<PointCluster>& clusters) : clusters_(clusters) {}
  ClusterList(const std::vector<VoxelLeaf>& leaves) : leaves_(leaves) {}
  /// `means` are those of the leaves once more: together they are read in less time.
  ClusterList(const std::vector<VoxelLeaf>& leaves, const std::vector<Eigen::Vector3d>& means)
      : leaves_(leaves), means_(means) {}

  std::size_t size() const { return clusters_.size() + leaves_.size(); }
  const PointCluster& operator[](std::size_t i) const {
    return leaves_.empty() ? clusters_[i] : leaves_[i].cluster;
  }
  const Eigen::Vector3d& Mean(std::size_t i) const {
    return means_.empty() ? (*this)[i].mean : means_[i];
  }

 private:
  std::span<const PointCluster> clusters_;
  std::span<const VoxelLeaf> leaves_;
  std::span<const Eigen::Vector3d> means_;
};

}  // namespace backsight
