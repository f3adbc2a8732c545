#pragma once

#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/plane_segmentation.h"

namespace backsight {

/// What planes that took no part in the adjustment say about two stations, metres.
struct HeldOutPair {
  int a = 0;
  int b = 0;  ///< a < b
  int planes = 0;
  double rms_before = 0.0;  ///< of the signed distances between the two stations' patches
  double rms_after = 0.0;
  double bias_before = 0.0;  ///< their mean; positive where b's patch is nearer to station a
  double bias_after = 0.0;
};

struct HeldOutComparison {
  std::vector<HeldOutPair> pairs;  ///< ascending; only those with common planes
  double mean_before_m2 = 0.0;     ///< mean squared distance over all pairs of patches
  /// Mean change of the squared distance, and its standard error, m^2.
  double mean_change_m2 = 0.0;
  double standard_error_m2 = 0.0;
};

/// True for about `share` of the cells, the same ones in every run.
bool IsHeldOut(std::uint64_t cell, double share);

/// Distances between patches along the normal that the two patches' own shapes give together, so
/// that their offset does not turn it.
HeldOutComparison CompareHeldOut(std::span<const PlaneAssociation> planes,
                                 std::span<const RigidTransform> before,
                                 std::span<const RigidTransform> after);

}  // namespace backsight
