#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/execution.h"
#include "stages/leaf_grid.h"

namespace backsight {

/// Unit normals of the grid's points, by their index: the direction of least scatter about the mean
/// of the points closer than `radius_m` (PCA). The sign is arbitrary; NaN where there are fewer
/// than three points. About 0.15 us a point for 40 neighbours.
std::vector<Eigen::Vector3f> EstimateNormals(const LeafGrid& grid, double radius_m,
                                             const ExecutionContext& context);

}  // namespace backsight
