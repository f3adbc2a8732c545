#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/execution.h"
#include "stages/leaf_grid.h"
#include "stages/station_model.h"

namespace backsight {

/// Fewest points of a slab: enough work for all threads between two waits.
inline constexpr std::size_t kFpfhSlabPoints = std::size_t{1} << 15U;

/// Fast point feature histograms (Rusu 2009, doi 10.1109/ROBOT.2009.5152473) of some of the grid's
/// points, one per key point, from the points closer than `radius_m` that have a normal.
///
/// SPFH(p) counts the pair features (PairHistogram) of p with its neighbours in three blocks of
/// 11 bins; FPFH(p) = sum over the neighbours q of SPFH(q) / |p - q|^2, each block then scaled to
/// sum to 100. Like PCL, the weight is 1 / d^2 where Rusu has 1 / d, and p's own SPFH is not in the
/// sum.
///
/// `normals` by index of the grid's points, of unit length or NaN; `keypoints` are such indices,
/// each once. A descriptor is NaN where its key point has no neighbour to be described by. Memory
/// 24 bytes per point, and 72 for each near a key point in the fullest slabs, three of them, which
/// hold `slab_points` at least and are no thinner than the radius; about 0.8 us for each with 250
/// neighbours. The bits do not depend on the slabs.
std::vector<FpfhDescriptor> ComputeFpfh(const LeafGrid& grid,
                                        std::span<const Eigen::Vector3f> normals,
                                        std::span<const std::uint32_t> keypoints, double radius_m,
                                        const ExecutionContext& context,
                                        std::size_t slab_points = kFpfhSlabPoints);

}  // namespace backsight
