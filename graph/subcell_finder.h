#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/cluster_list.h"

namespace backsight {

/// The subcells of a lattice (OctreeCells) that clusters' means lie in under one motion after
/// another. Memory 8 bytes for each cluster, 32 where they are not VoxelLeaves.
class SubcellFinder {
 public:
  /// The clusters must outlive it.
  explicit SubcellFinder(const ClusterList& clusters);
  SubcellFinder(const SubcellFinder&) = delete;  // means_ may lie in copied_
  SubcellFinder& operator=(const SubcellFinder&) = delete;

  std::size_t size() const { return keys_.size(); }
  /// Sets `keys` to the subcells of the lattice of root cells with edge `root_edge_m`.
  void Find(const RigidTransform& lattice_from_clusters, double root_edge_m);
  const std::vector<std::uint64_t>& keys() const { return keys_; }

 private:
  std::vector<Eigen::Vector3d> copied_;
  std::span<const Eigen::Vector3d> means_;
  std::vector<std::uint64_t> keys_;
};

}  // namespace backsight
