#pragma once

#include <span>
#include <vector>

#include "graph/planar_cost.h"
#include "stages/fine_registration.h"

namespace backsight {

/// Planes of a few rounds of association, each from where the last one left the poses.
struct PlaneRounds {
  bool enough = false;
  std::vector<WeightedPlane> planes;
  std::vector<RigidTransform> poses;
  Matrix6d information = Matrix6d::Zero();  ///< with the coarse result's
  Eigen::Matrix3Xd open;  ///< OpenTranslations: the coarse result's alone, target frame
};

/// Mean of the source's observations, target frame.
Eigen::Vector3d CenterOf(std::span<const WeightedPlane> planes,
                         const RigidTransform& target_from_source);

/// Seeks planes and adjusts, `options.rounds` times; adds to what `result` says of them. Gives up
/// where they are fewer than `options.min_planes`.
PlaneRounds AdjustOnPlanes(const FineInput& input, const FineOptions& options,
                           const ExecutionContext& context, FineResult* result);

}  // namespace backsight
