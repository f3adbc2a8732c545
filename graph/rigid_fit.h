#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/correspondences.h"

namespace backsight {

/// Weighted least-squares rigid motion: minimises sum w_a |T q_a - p_a|^2 in closed form (Kabsch
/// 1976, Umeyama 1991 doi 10.1109/34.88573). `weights` is empty (all one) or as long as `c`.
/// None if fewer than three rows carry weight or the points are collinear.
std::optional<RigidTransform> FitRigid(const Correspondences& c, std::span<const double> weights);

/// Rows whose residual |T q - p| is below `threshold_m`, in row order.
std::vector<std::uint32_t> RowsWithin(const Correspondences& c, const RigidTransform& transform,
                                      double threshold_m);

}  // namespace backsight
