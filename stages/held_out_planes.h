#pragma once

#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/plane_segmentation.h"

namespace backsight {

/// How squared distances between patches changed, m^2.
struct SquaredChange {
  double mean_before_m2 = 0.0;
  double mean_change_m2 = 0.0;
  double standard_error_m2 = 0.0;  ///< of the mean change

  /// True if they grew by more than `significance` standard errors, by more than a hundredth (many
  /// planes make a change significant that is a thousandth of their own scatter), and by more than
  /// the square of 0.01 mm (rounding).
  bool IsWorse(double significance) const;
};

/// What planes that took no part in the adjustment say about two stations, metres.
struct HeldOutPair {
  int a = 0;
  int b = 0;  ///< a < b
  int planes = 0;
  double rms_before = 0.0;  ///< of the signed distances between the two stations' patches
  double rms_after = 0.0;
  double bias_before = 0.0;  ///< their mean; positive where b's patch is nearer to station a
  double bias_after = 0.0;
  SquaredChange change;
};

struct HeldOutComparison {
  std::vector<HeldOutPair> pairs;  ///< ascending; only those with common planes
  SquaredChange change;            ///< over all pairs of patches
};

/// True for about `share` of the cells, the same ones in every run.
bool IsHeldOut(std::uint64_t cell, double share);

/// Distances between patches along the normal that the two patches' own shapes give together, so
/// that their offset does not turn it.
HeldOutComparison CompareHeldOut(std::span<const PlaneAssociation> planes,
                                 std::span<const RigidTransform> before,
                                 std::span<const RigidTransform> after);

}  // namespace backsight
