#pragma once

#include <span>
#include <vector>

#include "core/execution.h"
#include "core/point_cluster.h"
#include "core/rigid_transform.h"
#include "graph/cluster_list.h"

namespace backsight {

/// One plane's points as one station saw them: their cluster in that station's frame.
struct PlaneObservation {
  int station = 0;  ///< index into the poses
  PointCluster cluster;
};

/// A plane seen by two or more stations.
struct PlaneAssociation {
  std::vector<PlaneObservation> observations;  ///< ascending station
  std::uint64_t cell = 0;  ///< names the lattice cell and its depth; evenly distributed (a hash)
};

/// PlaneAssociation::cell of the cell at `depth` that `world_point` lies in.
std::uint64_t PlaneCell(const Eigen::Vector3d& world_point, double root_edge_m, int depth);

/// Adaptive octree plane search on clusters (docs/stages/fine_registration.md; the paper leaves its
/// details open). A lattice cell is split until what each station has in it is one thin plane and
/// the stations agree on it.
struct PlaneSearchOptions {
  double root_edge_m = 0.8;        ///< edge of the lattice cells the search starts from
  int max_depth = 3;               ///< how often a cell may be split
  double min_points = 15.0;        ///< raw points a station needs in a cell
  int min_clusters = 8;            ///< or voxels, where the scan is thinner than that
  double max_thinness = 1.0 / 16;  ///< smallest over middle eigenvalue of the covariance
  double min_width = 0.02;         ///< middle over largest eigenvalue: a plane, not a line
  double max_thickness_m = 0.03;   ///< standard deviation across the plane, per station
  double max_angle_rad = 0.175;    ///< between a station's normal and the joint one
  double max_offset_m = 0.1;       ///< of a station's centroid from the joint plane
};

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
