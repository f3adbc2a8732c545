#pragma once

#include <span>
#include <vector>

#include "graph/spanning_tree.h"

namespace backsight {

/// Per link, the squared error with which it closes its loop over the forest's links, under its own
/// covariance and theirs (chi^2 with 6 degrees of freedom if all are true); 0 for the forest's own
/// links, infinity where its ends are in different trees. Time O(links * depth).
std::vector<double> TreeLoopErrors(int stations, std::span<const PoseGraphLink> links,
                                   const SpanningForest& forest);

/// Per station, the covariance of its pose's perturbation in the frame of its tree's first station,
/// summed over the links on the way there; zero for that station. Time O(stations + links).
std::vector<Matrix6d> TreeCovariances(int stations, std::span<const PoseGraphLink> links,
                                      const SpanningForest& forest);

}  // namespace backsight
