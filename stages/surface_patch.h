#pragma once

#include <Eigen/Core>
#include <optional>

#include "stages/cloud_agreement.h"
#include "stages/station_model.h"

namespace backsight {

/// A piece of plane that a scan measured: the points of neighbouring voxels. Instrument frame.
struct SurfacePatch {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, towards the scanner
  double sigma_m = 0.0;                               ///< of the points across the plane
};

/// The plane of a cluster of points; none where it has fewer than 8 points, is no thin layer
/// (variances 1 to 16) or thicker than a tenth of a voxel's edge (standard deviation), or where the
/// points lie along a line (variances 1 to 20), as on the ground far from a scanner, whose rings
/// stand apart: the plane could turn about it.
std::optional<SurfacePatch> PatchOf(const PointCluster& cluster, double edge_m);

/// The plane of all voxels whose means lie within two edges of the leaf's: sparse scans have too
/// few points in one voxel. `index`: of the model. About 2 us.
std::optional<SurfacePatch> FindPatch(const StationModel& model, const CloudIndex& index,
                                      std::size_t leaf);

}  // namespace backsight
