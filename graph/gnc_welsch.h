#pragma once

#include <vector>

#include "core/rigid_transform.h"
#include "graph/correspondences.h"

namespace backsight {

/// Graduated non-convexity with the Welsch function rho(r) = 1 - exp(-r^2 / (2 sigma^2)) on SE(3)
/// (paper section III-D, Algorithm 1 with its schedule corrected: the scale falls geometrically and
/// never below sigma_min, so the result does not depend on the unit of length).
struct GncWelschOptions {
  double resolution_m = 0.1;  ///< l
  int annealing_steps = 20;   ///< geometric steps from sigma_0 to sigma_min, one per 2 iterations
  int max_iterations = 100;
};

struct GncWelschResult {
  enum class Status { kConverged, kMaxIterations, kDegenerate };
  Status status = Status::kDegenerate;
  RigidTransform target_from_source;  ///< the start value if degenerate
  std::vector<double> weights;        ///< z of every row, 0 to 1
  double sigma_m = 0.0;               ///< final scale
  double residual_sd_m = 0.0;         ///< per-axis standard deviation of the inliers
  int iterations = 0;
  /// Gauss-Newton information of the motion in Retract's convention, from residual_sd_m.
  Matrix6d information = Matrix6d::Zero();
};

/// Minimises sum rho(|T q - p|) from `start`. The final scale adapts to the inliers' own noise
/// within 0.5 l to 1.5 l. Time O(iterations * rows). Never fails with NaN: rows that do not
/// determine a motion give kDegenerate.
GncWelschResult EstimateGncWelsch(const Correspondences& c, const RigidTransform& start,
                                  const GncWelschOptions& options);

}  // namespace backsight
