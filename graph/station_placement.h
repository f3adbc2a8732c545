#pragma once

#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// Squared error of a link under its information, at `poses` (survey_from_station).
double SquaredError(const PoseGraphLink& link, std::span<const RigidTransform> poses);

/// Sum over the links of min(squared error, limit).
double TruncatedCost(std::span<const PoseGraphLink> links, std::span<const RigidTransform> poses,
                     double limit);

/// Gets a network out of a local minimum in which a station hangs on one false link: moves single
/// stations to where one of their links puts them, as long as that lowers the truncated cost. The
/// datum of every component is kept: its first station comes back to identity. Time O(passes *
/// links * links per station).
void MoveStationsToConsensus(std::span<const PoseGraphLink> links,
                             const std::vector<int>& component, double limit,
                             std::vector<RigidTransform>* poses);

}  // namespace backsight
