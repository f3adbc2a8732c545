#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/station_model.h"

namespace backsight {

/// A station in a walled yard with boxes and columns, scanned from the origin with range noise;
/// only what faces the scanner is measured. `size` scales the number of voxels: 1 gives some 15,000
/// at the resolution of 0.1 m. Drawn from `seed`.
StationModel MakeYardStation(std::uint64_t seed, double size = 1.0);
/// Its points.
std::vector<Eigen::Vector3d> ScanYard(std::uint64_t seed, double size = 1.0);

/// The station whose voxels hold these points, scanner at the origin and not vouched for.
StationModel MakeStation(std::span<const Eigen::Vector3d> points, double resolution_m);

/// Voxel means, float.
std::vector<Eigen::Vector3f> LeafPositions(const StationModel& model);

/// Median over the descriptors of |a - b| / |b|; 0 for none.
double MedianRelativeDifference(std::span<const FpfhDescriptor> a,
                                std::span<const FpfhDescriptor> b);

}  // namespace backsight
