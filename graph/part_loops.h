#pragma once

#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// Per link, how many loops close through it that lead from part to part of the network over
/// doubtful links; 0 for accepted links and for those within a part. A part is what accepted links
/// hold together, whose way from station to station over them is part of the loop, however long it
/// is. Loops have two parts (a loop for each other pair between them that asks for the same
/// motion), three, or, for links on none of three, four (one for each choice of parts, through the
/// six links between two parts that have most support). A loop closes if its squared error is at
/// most `limit` under all errors on it, those within parts taken from the part's first station.
/// Only links that are credible (kLeastCredibility) and know their motion to 0.3 m and 1 degree are
/// asked: others would agree by chance.
std::vector<int> CountPartLoops(int stations, std::span<const PoseGraphLink> links, double limit);

}  // namespace backsight
