#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/station_model.h"

namespace backsight {

/// A station's voxels as pieces of surface. Instrument frame.
struct Surface {
  const StationModel& model;
  const std::vector<Eigen::Vector3f>& normals;  ///< per leaf; NaN where undefined
};

struct SurfaceRefinement {
  RigidTransform target_from_source;
  int matches = 0;  ///< pairs of voxels in the last iteration
  int iterations = 0;
};

/// Generalised ICP on voxel means (Segal et al. 2009, doi 10.15607/RSS.2009.V.021), held by what
/// the planar adjustment knows: minimises the squared distances of nearest voxels, weighted by
/// their covariances, plus 0.5 r^T prior r, r = LocalDifference(T, start). A voxel's covariance is
/// `normal_sigma_m` across its surface and the voxel's edge along it. So curved and small surfaces,
/// which no plane covers, have their say; on dense scans the planes' information prevails.
/// At most 20,000 voxels of the source are used, evenly chosen. The start is returned where fewer
/// than 100 voxels match.
SurfaceRefinement RefineOnSurfaces(const Surface& source, const Surface& target,
                                   const RigidTransform& start, const Matrix6d& prior,
                                   double normal_sigma_m);

}  // namespace backsight
