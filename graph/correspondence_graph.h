#pragma once

#include <optional>
#include <vector>

#include "core/execution.h"
#include "graph/correspondences.h"

namespace backsight {

/// RGN, removal of outliers by node reliability (paper section III-B, Eqs. 2-4 with the weight's
/// dimension mended: exp(-x^2 / (6 l^2))).
struct NodeReliabilityOptions {
  double resolution_m = 0.1;  ///< l; two rows are compatible if their lengths differ by x < 2 l
  int keep = 800;             ///< K_opt
  std::optional<UprightConstraint> upright = {};  ///< compatible rows agree in height too
};

struct ReliableNodes {
  std::vector<std::uint32_t> rows;  ///< at most `keep`, most reliable first, ties by row
  std::vector<float> reliability;   ///< D of every row of the input
};

/// D(a) = sum over b of w(x_ab), x_ab = | |p_a - p_b| - |q_a - q_b| | < 2 l, where both lengths are
/// positive (rows that share a key point do not vouch for each other).
/// Time O(K1^2), memory O(K1); the result does not depend on the number of threads.
ReliableNodes SelectReliableNodes(const Correspondences& c, const NodeReliabilityOptions& options,
                                  const ExecutionContext& context);

}  // namespace backsight
