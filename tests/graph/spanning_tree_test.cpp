#include "graph/spanning_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/support/matchers.h"

namespace backsight {
namespace {

/// Component numbers by spreading labels, from the first station.
std::vector<int> Components(int stations, const std::vector<PoseGraphLink>& links,
                            unsigned subset) {
  std::vector<int> label(static_cast<std::size_t>(stations));
  std::iota(label.begin(), label.end(), 0);
  for (int pass = 0; pass < stations; ++pass) {
    for (std::size_t l = 0; l < links.size(); ++l) {
      if ((subset >> l & 1U) == 0) continue;
      int& a = label[static_cast<std::size_t>(links[l].source)];
      int& b = label[static_cast<std::size_t>(links[l].target)];
      a = b = std::min(a, b);
    }
  }
  std::vector<int> numbers = label;
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  for (int& x : label) {
    x = static_cast<int>(std::find(numbers.begin(), numbers.end(), x) - numbers.begin());
  }
  return label;
}

double Weight(const std::vector<PoseGraphLink>& links, unsigned subset) {
  double sum = 0.0;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if ((subset >> l & 1U) != 0) sum += links[l].confidence;
  }
  return sum;
}

/// The largest confidence of any subset that joins what all links join without a loop.
double BestForest(int stations, const std::vector<PoseGraphLink>& links, unsigned allowed) {
  const std::vector<int> target = Components(stations, links, allowed);
  const int components = 1 + *std::max_element(target.begin(), target.end());
  double best = -1.0;
  for (unsigned subset = 0; subset < 1U << links.size(); ++subset) {
    if ((subset & ~allowed) != 0) continue;
    if (__builtin_popcount(subset) != stations - components) continue;
    if (Components(stations, links, subset) == target) best = std::max(best, Weight(links, subset));
  }
  return best;
}

TEST(BuildSpanningForest, EqualsBruteForce) {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    const int stations = 2 + static_cast<int>(random.Index(5));
    std::vector<PoseGraphLink> links(random.Index(10));
    std::vector<char> use;
    unsigned allowed = 0;
    for (std::size_t l = 0; l < links.size(); ++l) {
      links[l].source = static_cast<int>(random.Index(static_cast<unsigned>(stations)));
      links[l].target = (links[l].source + 1 +
                         static_cast<int>(random.Index(static_cast<unsigned>(stations - 1)))) %
                        stations;
      links[l].confidence = random.Uniform();
      links[l].target_from_source = RandomTransform(random, 10.0);
      use.push_back(random.Uniform() < 0.8 ? 1 : 0);
      if (use.back() != 0) allowed |= 1U << l;
    }
    const SpanningForest forest = BuildSpanningForest(stations, links, use);
    EXPECT_EQ(forest.component, Components(stations, links, allowed));
    unsigned tree = 0;
    for (const int l : forest.tree_links) tree |= 1U << static_cast<unsigned>(l);
    EXPECT_EQ(tree & ~allowed, 0U);
    EXPECT_NEAR(Weight(links, tree), BestForest(stations, links, allowed), 1e-12);
    for (const int l : forest.tree_links) {
      const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
      const auto& source = forest.survey_from_station[static_cast<std::size_t>(link.source)];
      const auto& target = forest.survey_from_station[static_cast<std::size_t>(link.target)];
      EXPECT_TRANSFORM_NEAR(target.Inverse() * source, link.target_from_source, 1e-12, 1e-10);
    }
    for (int c = 0; c <= *std::max_element(forest.component.begin(), forest.component.end()); ++c) {
      const auto first = std::find(forest.component.begin(), forest.component.end(), c);
      const auto s = static_cast<std::size_t>(first - forest.component.begin());
      EXPECT_EQ(forest.survey_from_station[s].Matrix(),
                Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
    }
  }
}

TEST(BuildSpanningForest, TiesGoByLink) {
  std::vector<PoseGraphLink> links(3);
  links[0].source = 0, links[0].target = 1;
  links[1].source = 1, links[1].target = 2;
  links[2].source = 2, links[2].target = 0;
  EXPECT_EQ(BuildSpanningForest(3, links, {}).tree_links, (std::vector<int>{0, 1}));
}

TEST(BuildSpanningForest, EmptyInput) {
  EXPECT_TRUE(BuildSpanningForest(0, {}, {}).component.empty());
  EXPECT_EQ(BuildSpanningForest(3, {}, {}).component, (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace backsight
