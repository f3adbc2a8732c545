#pragma once

#include "graph/planar_cost.h"

namespace backsight {

/// PA-AA: planar adjustment by Levenberg-Marquardt on the Gauss-Newton matrix, with Anderson
/// acceleration behind a cost safeguard (paper section III-E; its start damping and missing
/// roll-back mended).
struct PlanarAdjustmentOptions {
  int max_iterations = 50;
  double start_damping = 1e-4;
  double relative_decrease = 1e-8;      ///< stop below this
  double smallest_rotation_rad = 1e-8;  ///< stop where a step is below both of these
  double smallest_translation_m = 1e-7;
  int anderson_window = 5;  ///< h; 0 switches the acceleration off
};

struct PlanarAdjustmentResult {
  enum class Status {
    kConverged,
    kMaxIterations,
    kNoDescent,    ///< damping grew to its limit without a lower cost: poses as good as they get
    kNothingToDo,  ///< no planes: poses unchanged
  };
  Status status = Status::kNothingToDo;
  std::vector<RigidTransform> poses;  ///< world_from_station
  double start_cost = 0.0;
  double final_cost = 0.0;
  int iterations = 0;  ///< accepted and rejected Levenberg-Marquardt steps
  int anderson_accepted = 0;
  /// Gauss-Newton matrix at the result, 6 rows per station, without damping, with all observations;
  /// planes leave the rows and columns of the fixed station zero.
  Eigen::MatrixXd information;
};

/// Moves all stations but `fixed_station` to the least cost. The cost never rises; a rejected step
/// restores the poses. With no planes the poses come back unchanged, never NaN.
PlanarAdjustmentResult AdjustPlanes(const PlanarProblem& problem,
                                    std::span<const RigidTransform> start, int fixed_station,
                                    const PlanarAdjustmentOptions& options);
PlanarAdjustmentResult AdjustPlanes(std::span<const WeightedPlane> planes,
                                    std::span<const PosePrior> priors,
                                    std::span<const RigidTransform> start, int fixed_station,
                                    const PlanarAdjustmentOptions& options);

}  // namespace backsight
