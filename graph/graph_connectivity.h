#pragma once

#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// In all of these, links with `use[l]` false do not exist (empty: all exist), and two links
/// between the same stations are two ways from one to the other.

/// Component of every station, numbered by first station. Time O(stations + links).
std::vector<int> FindComponents(int stations, std::span<const PoseGraphLink> links,
                                std::span<const char> use);

/// Per link: true if it is used and its ends fall apart without it (Tarjan 1974, doi
/// 10.1016/0020-0190(74)90003-9). Time O(stations + links).
std::vector<char> FindBridges(int stations, std::span<const PoseGraphLink> links,
                              std::span<const char> use);

/// How many ways from `from` to `to` share no link, counted up to `limit` (augmenting paths). Time
/// O(limit * (stations + links)).
int CountDisjointPaths(int stations, std::span<const PoseGraphLink> links,
                       std::span<const char> use, int from, int to, int limit);

}  // namespace backsight
