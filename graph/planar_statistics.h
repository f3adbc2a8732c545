#pragma once

#include <Eigen/Core>
#include <span>

#include "graph/block_equations.h"

namespace backsight {

/// How well the stations of a plane agree, free of how thick each one's patch is.
struct PlaneAgreement {
  double own_thickness_m2 = 0.0;  ///< mean squared distance of each patch from its own best plane
  /// By how much the sum of squared distances grows where one plane has to do for all patches;
  /// sigma squared times chi^2 with `freedom` degrees where the patches' errors are independent.
  double excess_m2 = 0.0;
  int freedom = 0;  ///< 3 (patches - 1)
};

PlaneAgreement Agreement(const WeightedPlane& plane, std::span<const RigidTransform> poses);

/// Estimated ratio of true to formal variance of the poses.
struct VarianceFactor {
  double factor = 1.0;
  double effective_blocks = 0.0;  ///< how many equal independent blocks would tell as much
};

/// From the scatter of the observations' pulls on the poses, gathered in blocks whose errors are
/// taken as independent of each other, but not of one another within. With g_b, G_b a block's
/// gradient and Gauss-Newton matrix at the minimum and C the formal joint covariance (6 rows per
/// pose, zero for the fixed station),
///   factor = sum_b g_b^T C g_b / sum_b [tr(C G_b) - tr(C G_b C G_b)],
/// whose expectation is 1 where weights are honest and blocks independent, the second trace being
/// what the adjustment itself takes out of a block's pull. It is the scalar form of the
/// cluster-robust covariance (Liang and Zeger 1986, doi 10.1093/biomet/73.1.13; leverage as in Bell
/// and McCaffrey 2002). Blocks are worked on side by side and summed in order.
VarianceFactor EstimateVarianceFactor(const BlockMembers& members,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance,
                                      const ExecutionContext& context);

}  // namespace backsight
