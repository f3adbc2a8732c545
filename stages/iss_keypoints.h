#pragma once

#include <cstdint>
#include <vector>

#include "core/execution.h"
#include "stages/leaf_grid.h"

namespace backsight {

/// Lengths in metres.
struct IssParameters {
  double salient_radius_m = 0.6;
  double non_max_radius_m = 0.4;  ///< the largest that is tried
  double gamma_21 = 0.975;
  double gamma_32 = 0.975;
  int min_neighbors = 4;  ///< counts the point itself
  int keypoints = 0;      ///< fewest wanted; 0 keeps to non_max_radius_m
};

/// Intrinsic shape signature key points (Zhong 2009, doi 10.1109/ICCVW.2009.5457637).
///
/// A point's scatter M = sum (x - x0)(x - x0)^T over the points x closer than the salient radius,
/// about the point x0 itself, has the eigenvalues e1 >= e2 >= e3. Where there are min_neighbors
/// points and e2 / e1 < gamma_21 and e3 / e2 < gamma_32, its saliency is e3, otherwise 0. A key
/// point is salient, has min_neighbors points closer than the suppression radius and none among
/// them that is more salient; equals stand side by side. Like PCL, neighbours are not weighted by
/// density.
///
/// The suppression radius adapts: non_max_radius_m and then 3/4, 1/2 and 3/8 of it are tried until
/// there are `keypoints` key points; the last try stands otherwise. Few key points leave a pair
/// with few true correspondences: on ETH Facade, 2600 key points a station instead of 770 halve the
/// error of the coarse transform, and on indoor fragments 13 instead of 12 of 13 pairs are found.
///
/// Returns indices of the grid's points, ascending. About 0.4 us a point for 150 neighbours.
std::vector<std::uint32_t> FindIssKeypoints(const LeafGrid& grid, const IssParameters& parameters,
                                            const ExecutionContext& context);

}  // namespace backsight
