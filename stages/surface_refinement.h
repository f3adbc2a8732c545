#pragma once

#include <vector>

#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"

namespace backsight {

struct SurfaceRefinementOptions {
  enum class Covariance {
    kSurface,  ///< `normal_sigma_m` across the voxel's surface, its edge along it
    kCluster,  ///< that of the voxel's own points, drawn to a filled voxel where they are few
  };
  Covariance covariance = Covariance::kSurface;
  double normal_sigma_m = 0.001;
  std::size_t sample = 40000;  ///< voxels of the source that are used at most, evenly chosen
  int max_iterations = 10;
};

struct SurfaceRefinement {
  RigidTransform target_from_source;
  int matches = 0;  ///< pairs of voxels in the last iteration
  int iterations = 0;
  /// What the pairs know of the motion, without the prior: the inverse of H^-1 M H^-1 with the
  /// normal matrix H and M the scatter of its gradient over cubes of 20 voxels (White 1980, doi
  /// 10.2307/1912934, by clusters), and of l / 50 that all pairs share. Pairs within a cube share
  /// their errors, so counting pairs would be too bold. Zero where fewer than 30 cubes hold pairs.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the pairs, target frame
  double spread_m = 0.0;                             ///< their rms distance from it
};

/// Generalised ICP on voxel means (Segal et al. 2009, doi 10.15607/RSS.2009.V.021): minimises the
/// squared distances of nearest voxels, weighted by their covariances, plus 0.5 r^T prior r, r =
/// LocalDifference(T, start). With kSurface only voxels of like normal pair; with kCluster all do,
/// and Cauchy weights take wrong pairs out. So curved and small surfaces, which no plane covers,
/// have their say; on dense scans the planes' information prevails. The start is returned, with
/// zero information, where fewer than 100 voxels match. `target_index` is the target's.
/// Time O(iterations * sample).
SurfaceRefinement RefineOnSurfaces(const Surface& source, const Surface& target,
                                   const CloudIndex& target_index, const RigidTransform& start,
                                   const Matrix6d& prior, const SurfaceRefinementOptions& options);

/// A few steps of it on 2,000 voxels: enough to compare motions.
RigidTransform RefineRoughly(const Surface& source, const Surface& target,
                             const CloudIndex& target_index,
                             const RigidTransform& target_from_source);

}  // namespace backsight
