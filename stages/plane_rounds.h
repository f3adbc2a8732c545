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
  Matrix6d of_planes = Matrix6d::Zero();  ///< their information, none on what is open
  Eigen::Matrix3Xd open{3, 0};            ///< OpenTranslations: held where the rounds began
};

/// Mean of the source's observations, source frame.
Eigen::Vector3d CenterOf(std::span<const WeightedPlane> planes);

/// Seeks planes and adjusts, `options.rounds` times, each time from where the last one ended but
/// for translations that the planes leave open; adds to what `result` says of them. Gives up
/// where they are fewer than `options.min_planes`.
PlaneRounds AdjustOnPlanes(const FineInput& input, const FineOptions& options,
                           const ExecutionContext& context, FineResult* result);

}  // namespace backsight
