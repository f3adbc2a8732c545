#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/kernel_motion.h"

namespace backsight {

/// Pieces of surface of a source and, for each, the one of a target that lay nearest when it was
/// last asked for. Columns of x, y and z, padded by kSurfacePadding entries of NaN.
struct SurfacePairColumns {
  std::array<const double*, 3> point;   ///< source, its own frame, m
  std::array<const double*, 3> normal;  ///< unit
  std::array<const double*, 3> asked;   ///< where the point lay then, target frame
  std::array<const double*, 3> fixed;   ///< the nearest of the target; NaN where there was none
  std::array<const double*, 3> fixed_normal;  ///< NaN where undefined
  const double* others;  ///< distance of all but the nearest from where it was asked, at least
  std::size_t count;
};
inline constexpr std::size_t kSurfacePadding = 8;

/// Entries whose nearest may be another one under `motion`, ascending; `found` has room for all.
/// "None within `reach_m`" is an answer too. Returns their number.
std::size_t FindUncertain(const SurfacePairColumns& pairs, const KernelMotion& motion,
                          double reach_m, std::uint32_t* found);

struct SurfacePairRule {
  double reach_m = 0.0;          ///< between a point and the nearest
  double least_cosine = 0.0;     ///< between their normals
  double along_variance = 0.0;   ///< of a point along its surface, m^2
  double across_variance = 0.0;  ///< and across it
};

/// Normal equations of the pairs that obey the rule, xi about the target's origin, rotation first:
/// sums of J^T W J and J^T W r with J = [-[m]x, I], r = m - fixed, m the moved point and W the
/// inverse of the sum of both points' covariances. Summed in eight lanes: the same bits on all
/// instruction sets.
struct SurfacePairSums {
  std::array<double, 21> matrix;  ///< lower triangle, row by row
  std::array<double, 6> gradient;
  double matches = 0.0;
};
SurfacePairSums SumSurfacePairs(const SurfacePairColumns& pairs, const KernelMotion& motion,
                                const SurfacePairRule& rule);

}  // namespace backsight
