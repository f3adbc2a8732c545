#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "graph/correspondences.h"

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

struct EdgeHypothesis {
  RigidTransform target_from_source;
  int consensus = 0;  ///< distinct source key points within 2 l of their target
};

/// `c` holds the nodes in the order of their reliability (SelectReliableNodes). Best hypotheses
/// first; none where no edge gathers more than three key points. Hypotheses closer to each other
/// than 2 deg and 6 l (at the nodes' centroid) count as one.
/// Time O(K^2 + E K log K) for K rows and E edges that pass the loose bound. A heuristic: it is the
/// best over at most K * edges_per_node edges, not a proven maximum.
std::vector<EdgeHypothesis> FindEdgeHypotheses(const Correspondences& c,
                                               const EdgeReliabilityOptions& options,
                                               const ExecutionContext& context);

/// An interval of rotation angles, in radians, within which key point `id` is satisfied. May pass
/// 2 pi (end > 2 pi wraps around).
struct AngleInterval {
  double begin = 0.0;
  double end = 0.0;
  std::uint32_t id = 0;
};

struct StabbingResult {
  int count = 0;       ///< distinct ids at the best angle
  double angle = 0.0;  ///< middle of the first best segment, in [0, 2 pi)
};

/// The angle that lies in the intervals of the most distinct ids (interval stabbing on the circle).
/// Time O(n log n).
StabbingResult StabIntervals(std::span<const AngleInterval> intervals);

}  // namespace backsight
