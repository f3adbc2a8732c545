#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/execution.h"

namespace backsight {

/// The points, some 10 million, that a scanner at the origin measures in the middle of a street of
/// houses, trees, parked cars and lamps. Takes about half a minute.
std::vector<Eigen::Vector3d> ScanStreet(const ExecutionContext& context);

}  // namespace backsight
