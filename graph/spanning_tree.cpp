#include "graph/spanning_tree.h"

#include <algorithm>
#include <numeric>

namespace backsight {
namespace {

class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(static_cast<std::size_t>(n)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Find(int i) {
    while (parent_[Slot(i)] != i) i = parent_[Slot(i)] = parent_[Slot(parent_[Slot(i)])];
    return i;
  }
  bool Unite(int a, int b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return false;
    parent_[Slot(std::max(a, b))] = std::min(a, b);  // the root is the first station
    return true;
  }

 private:
  static std::size_t Slot(int i) { return static_cast<std::size_t>(i); }
  std::vector<int> parent_;
};

/// Chains poses outward from the stations in `placed` along the tree's links.
void ChainPoses(std::span<const PoseGraphLink> links, const std::vector<int>& tree_links,
                std::vector<char> placed, std::vector<RigidTransform>* poses) {
  for (bool grown = true; grown;) {
    grown = false;
    for (const int l : tree_links) {
      const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
      const auto source = static_cast<std::size_t>(link.source);
      const auto target = static_cast<std::size_t>(link.target);
      if (placed[source] == placed[target]) continue;
      if (placed[target] != 0) {
        (*poses)[source] = (*poses)[target] * link.target_from_source;
      } else {
        (*poses)[target] = (*poses)[source] * link.target_from_source.Inverse();
      }
      placed[source] = placed[target] = 1;
      grown = true;
    }
  }
}

}  // namespace

SpanningForest BuildSpanningForest(int stations, std::span<const PoseGraphLink> links,
                                   std::span<const char> use) {
  std::vector<int> order;
  for (int l = 0; l < static_cast<int>(links.size()); ++l) {
    if (use.empty() || use[static_cast<std::size_t>(l)] != 0) order.push_back(l);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return links[static_cast<std::size_t>(a)].confidence >
           links[static_cast<std::size_t>(b)].confidence;
  });
  return BuildForestInOrder(stations, links, order);
}

SpanningForest BuildForestInOrder(int stations, std::span<const PoseGraphLink> links,
                                  std::span<const int> order) {
  SpanningForest forest;
  DisjointSets sets(stations);
  for (const int l : order) {
    const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
    if (sets.Unite(link.source, link.target)) forest.tree_links.push_back(l);
  }

  std::vector<char> is_root(static_cast<std::size_t>(stations), 0);
  std::vector<int> number(static_cast<std::size_t>(stations), -1);
  int components = 0;
  for (int s = 0; s < stations; ++s) {
    const auto root = static_cast<std::size_t>(sets.Find(s));
    if (number[root] < 0) number[root] = components++;
    is_root[root] = 1;
    forest.component.push_back(number[root]);
  }
  forest.survey_from_station.resize(static_cast<std::size_t>(stations));
  ChainPoses(links, forest.tree_links, is_root, &forest.survey_from_station);
  return forest;
}

}  // namespace backsight
