#pragma once

#include <optional>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "graph/correspondences.h"
#include "graph/edge_evaluator.h"

namespace backsight {

/// RGE, removal of outliers by edge reliability (paper section III-C): an edge is a pair of
/// compatible correspondences; it fixes the motion up to one rotation about itself, and its
/// reliability is the largest number of key points that one such rotation brings together.
struct EdgeReliabilityOptions {
  double resolution_m = 0.1;  ///< l
  int min_compatible = 10;    ///< nodes with fewer compatible partners start no edge
  int edges_per_node = 1;     ///< partners tried per node, most reliable first
  int hypotheses = 20;        ///< distinct hypotheses kept, best first
  /// Levelled instruments: an edge fixes the motion by its bearing, and all rows agree in height.
  std::optional<UprightConstraint> upright = {};
};

/// `c` holds the nodes in the order of their reliability (SelectReliableNodes). Best hypotheses
/// first; none where no edge gathers more than three key points. Hypotheses closer to each other
/// than 2 deg and 6 l (at the nodes' centroid) count as one.
/// Time O(K^2 + E K log K) for K rows and E edges that pass the loose bound. A heuristic: it is the
/// best over at most K * edges_per_node edges, not a proven maximum.
std::vector<EdgeHypothesis> FindEdgeHypotheses(const Correspondences& c,
                                               const EdgeReliabilityOptions& options,
                                               const ExecutionContext& context);

}  // namespace backsight
