#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/iss_keypoints.h"
#include "stages/station_model.h"

namespace backsight {

/// PCL's implementations behind our types: the reference that ours are compared with.
std::vector<Eigen::Vector3f> PclNormals(std::span<const Eigen::Vector3f> points, double radius_m);

/// Key points for parameters.non_max_radius_m as it stands, ascending.
std::vector<std::uint32_t> PclIssKeypoints(std::span<const Eigen::Vector3f> points,
                                           const IssParameters& parameters);

std::vector<FpfhDescriptor> PclFpfh(std::span<const Eigen::Vector3f> points,
                                    std::span<const Eigen::Vector3f> normals,
                                    std::span<const std::uint32_t> keypoints, double radius_m);

}  // namespace backsight
