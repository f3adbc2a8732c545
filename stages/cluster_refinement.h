#pragma once

#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"

namespace backsight {

struct ClusterRefinement {
  RigidTransform target_from_source;
  int matches = 0;  ///< pairs of voxels in the last iteration
  /// What the pairs know of the motion, without the prior: the inverse of H^-1 M H^-1 with the
  /// normal matrix H and M the scatter of its gradient over cubes of 20 voxels (White 1980, doi
  /// 10.2307/1912934, by clusters), and of l / 50 that all pairs share. Pairs within a cube share
  /// their errors, so counting pairs would be too bold. Zero where fewer than 30 cubes hold pairs.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the pairs, target frame
  double spread_m = 0.0;                             ///< their rms distance from it
};

/// Generalised ICP on voxel means (Segal et al. 2009, doi 10.15607/RSS.2009.V.021) where planes are
/// too few: minimises the squared distances of nearest voxels, weighted by the covariances of their
/// own points, which are drawn to a filled voxel where those are few, plus 0.5 r^T prior r,
/// r = LocalDifference(T, start). Every voxel pairs, whatever its normal; Cauchy
/// weights take wrong pairs out. Up to 40,000 voxels of the source, evenly chosen, take part. The
/// start is returned, with zero information, where fewer than 100 match. `target_index` is the
/// target's.
ClusterRefinement RefineOnClusters(const Surface& source, const Surface& target,
                                   const CloudIndex& target_index, const RigidTransform& start,
                                   const Matrix6d& prior);

}  // namespace backsight
