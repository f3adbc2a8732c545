#include "graph/tree_loops.h"

#include <gtest/gtest.h>

#include "graph/cycle_consistency.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

TEST(TreeLoopErrors, EqualTheMisclosureOfTheLoop) {
  // Chain 0-1-2-3-4 and a link that closes it: one loop, two ways to compute its error.
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto network = MakeNetwork(seed, 5, 0.0, 1.0);
    Random random(seed);
    PoseGraphLink closing = network.links[0];
    closing.source = 1, closing.target = 4;
    closing.target_from_source =
        network.survey_from_station[4].Inverse() * network.survey_from_station[1];
    network.links.push_back(closing);
    const std::vector<int> tree{0, 1, 2, 3};
    const auto forest = BuildForestInOrder(5, network.links, tree);
    const auto errors = TreeLoopErrors(5, network.links, forest);
    std::vector<Matrix6d> covariances;
    for (const PoseGraphLink& link : network.links) {
      covariances.push_back(CovarianceOf(link.information));
    }
    const std::vector<int> loop{1, 2, 3, 4};
    const double expected = CloseLoop(network.links, covariances, loop, 1).SquaredError();
    // The one takes its derivatives at the misclosure, the other at zero.
    EXPECT_NEAR(errors[4], expected, 1e-2 * expected);
    for (const int l : tree) EXPECT_EQ(errors[static_cast<std::size_t>(l)], 0.0);
  }
}

TEST(TreeLoopErrors, AreChiSquaredHoweverLongTheLoop) {
  double mean = 0.0;
  constexpr int kSeeds = 300;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    auto network = MakeNetwork(seed, 9, 0.0, 1.0);
    PoseGraphLink closing = MakeNetwork(seed + 1000, 2, 0.0, 1.0).links[0];
    const Vector6d error =
        LocalDifference(closing.target_from_source,
                        MakeNetwork(seed + 1000, 2, 0.0, 0.0).links[0].target_from_source);
    closing.source = 0, closing.target = 8;
    closing.target_from_source =
        Retract(network.survey_from_station[8].Inverse() * network.survey_from_station[0], error);
    network.links.push_back(closing);
    const std::vector<int> tree{0, 1, 2, 3, 4, 5, 6, 7};
    const auto forest = BuildForestInOrder(9, network.links, tree);
    mean += TreeLoopErrors(9, network.links, forest)[8] / kSeeds;
  }
  EXPECT_NEAR(mean, 6.0, 0.8);  // standard error sqrt(12 / 300) = 0.2
}

TEST(TreeLoopErrors, BetweenTreesThereIsNoLoop) {
  auto network = MakeNetwork(1, 4, 0.0, 1.0);
  const std::vector<int> tree{0, 2};
  const auto errors = TreeLoopErrors(4, network.links, BuildForestInOrder(4, network.links, tree));
  EXPECT_TRUE(std::isinf(errors[1]));
}

}  // namespace
}  // namespace backsight
