#pragma once

#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// A maximum spanning forest by confidence (Kruskal; ties by link index), and what hangs together.
struct SpanningForest {
  std::vector<int> component;                       ///< per station, numbered by first station
  std::vector<int> tree_links;                      ///< link indices
  std::vector<RigidTransform> survey_from_station;  ///< chained along the tree from each
                                                    ///< component's first station
};

/// Uses the links with `use[l]` true (all if empty).
SpanningForest BuildSpanningForest(int stations, std::span<const PoseGraphLink> links,
                                   std::span<const char> use);

/// The same with the links taken in the given order instead of by confidence; links that are not in
/// it are not used.
SpanningForest BuildForestInOrder(int stations, std::span<const PoseGraphLink> links,
                                  std::span<const int> order);

}  // namespace backsight
