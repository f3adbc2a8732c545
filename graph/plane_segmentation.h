#pragma once

#include <span>
#include <vector>

#include "core/execution.h"
#include "core/point_cluster.h"
#include "core/rigid_transform.h"
#include "graph/cluster_list.h"
#include "graph/plane_judge.h"

namespace backsight {

/// A plane seen by two or more stations.
struct PlaneAssociation {
  std::vector<PlaneObservation> observations;  ///< ascending station
  std::uint64_t cell = 0;  ///< names the lattice cell and its depth; evenly distributed (a hash)
};

/// PlaneAssociation::cell of the cell at `depth` that `world_point` lies in, or of the one with
/// these coordinates on the lattice of its depth.
std::uint64_t PlaneCell(const Eigen::Vector3d& world_point, double root_edge_m, int depth);
std::uint64_t PlaneCell(const Eigen::Vector3i& cell, int depth);

/// `clusters[s]` are station s's voxel clusters in its own frame, `poses[s]` its
/// world_from_station; a cluster belongs to the cell its mean lies in. Planes come in the order of
/// their lattice cells; the world lattice passes through the world's origin. `context` (may be
/// null: one thread) changes the time only. Time O(clusters * depth). Memory: 4 bytes for each
/// cluster, 8 for each in a root cell that two or more stations see, and the planes found; sums are
/// formed in the stations' frames and moved to the world, not the clusters.
std::vector<PlaneAssociation> FindPlanes(std::span<const ClusterList> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options,
                                         const ExecutionContext* context = nullptr);
std::vector<PlaneAssociation> FindPlanes(std::span<const std::vector<PointCluster>* const> clusters,
                                         std::span<const RigidTransform> poses,
                                         const PlaneSearchOptions& options);

}  // namespace backsight
