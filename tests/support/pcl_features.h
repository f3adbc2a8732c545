#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "stages/iss_keypoints.h"
#include "stages/station_model.h"

namespace backsight {

/// PCL's implementations behind our types: the reference that ours are compared with.

/// Returns the means of the points in the voxels of an edge as VoxelGrid finds them; the points are
/// PCL's before.
std::function<std::vector<Eigen::Vector3f>()> PclVoxelGrid(std::span<const Eigen::Vector3d> points,
                                                           double edge_m);

std::vector<Eigen::Vector3f> PclNormals(std::span<const Eigen::Vector3f> points, double radius_m);

/// Key points for parameters.non_max_radius_m as it stands, ascending.
std::vector<std::uint32_t> PclIssKeypoints(std::span<const Eigen::Vector3f> points,
                                           const IssParameters& parameters);

std::vector<FpfhDescriptor> PclFpfh(std::span<const Eigen::Vector3f> points,
                                    std::span<const Eigen::Vector3f> normals,
                                    std::span<const std::uint32_t> keypoints, double radius_m);

}  // namespace backsight
