#include "graph/graph_connectivity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/random.h"

namespace backsight {
namespace {

std::vector<PoseGraphLink> RandomLinks(Random& random, int stations, int count) {
  std::vector<PoseGraphLink> links(static_cast<std::size_t>(count));
  for (PoseGraphLink& link : links) {
    link.source = static_cast<int>(random.Index(static_cast<unsigned>(stations)));
    link.target =
        (link.source + 1 + static_cast<int>(random.Index(static_cast<unsigned>(stations - 1)))) %
        stations;
  }
  return links;
}

TEST(FindComponents, SpreadsLabels) {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    const int stations = 2 + static_cast<int>(random.Index(8));
    const auto links = RandomLinks(random, stations, static_cast<int>(random.Index(8)));
    std::vector<int> label;
    for (int s = 0; s < stations; ++s) label.push_back(s);
    for (int pass = 0; pass < stations; ++pass) {
      for (const PoseGraphLink& link : links) {
        int& a = label[static_cast<std::size_t>(link.source)];
        int& b = label[static_cast<std::size_t>(link.target)];
        a = b = std::min(a, b);
      }
    }
    const auto component = FindComponents(stations, links, {});
    int next = 0;
    for (int s = 0; s < stations; ++s) {
      const auto i = static_cast<std::size_t>(s);
      if (label[i] == s) {
        EXPECT_EQ(component[i], next++);
      }
      EXPECT_EQ(component[i], component[static_cast<std::size_t>(label[i])]);
    }
  }
}

TEST(FindBridges, EqualsLeavingOutEachLink) {
  Random random(2);
  for (int round = 0; round < 300; ++round) {
    const int stations = 2 + static_cast<int>(random.Index(9));
    const auto links = RandomLinks(random, stations, static_cast<int>(random.Index(14)));
    std::vector<char> use;
    for (std::size_t l = 0; l < links.size(); ++l) use.push_back(random.Uniform() < 0.8 ? 1 : 0);
    const auto bridges = FindBridges(stations, links, use);
    for (std::size_t l = 0; l < links.size(); ++l) {
      auto others = use;
      others[l] = 0;
      const auto component = FindComponents(stations, links, others);
      const bool apart = component[static_cast<std::size_t>(links[l].source)] !=
                         component[static_cast<std::size_t>(links[l].target)];
      EXPECT_EQ(bridges[l] != 0, use[l] != 0 && apart) << round << " link " << l;
    }
  }
}

TEST(CountDisjointPaths, EqualsTheSmallestCut) {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    const int stations = 2 + static_cast<int>(random.Index(6));
    const auto links = RandomLinks(random, stations, static_cast<int>(random.Index(16)));
    int smallest = 1000;  // over all sets that hold station 0 and not station 1
    for (unsigned set = 0; set < 1U << static_cast<unsigned>(stations); ++set) {
      if ((set & 1U) == 0 || (set & 2U) != 0) continue;
      int across = 0;
      for (const PoseGraphLink& link : links) {
        across += (set >> static_cast<unsigned>(link.source) & 1U) !=
                          (set >> static_cast<unsigned>(link.target) & 1U)
                      ? 1
                      : 0;
      }
      smallest = std::min(smallest, across);
    }
    EXPECT_EQ(CountDisjointPaths(stations, links, {}, 0, 1, 100), smallest);
    EXPECT_EQ(CountDisjointPaths(stations, links, {}, 0, 1, 2), std::min(smallest, 2));
  }
}

}  // namespace
}  // namespace backsight
