#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/point_cluster.h"
#include "core/voxel_leaves.h"

namespace backsight {

/// One station's voxel clusters, wherever they are kept; a view.
class ClusterList {
 public:
  ClusterList(const std::vector<PointCluster>& clusters) : clusters_(clusters) {}
  ClusterList(const VoxelLeaves& leaves) : leaves_(&leaves) {}

  std::size_t size() const { return leaves_ != nullptr ? leaves_->size() : clusters_.size(); }
  PointCluster operator[](std::size_t i) const {
    return leaves_ != nullptr ? leaves_->Cluster(i) : clusters_[i];
  }
  Eigen::Vector3d Mean(std::size_t i) const {
    return leaves_ != nullptr ? leaves_->Mean(i) : clusters_[i].mean;
  }
  double Count(std::size_t i) const {
    return leaves_ != nullptr ? leaves_->Count(i) : clusters_[i].count;
  }

 private:
  const VoxelLeaves* leaves_ = nullptr;
  std::span<const PointCluster> clusters_;
};

}  // namespace backsight
