#include "graph/part_loops.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

constexpr double kLimit = 16.81;  // chi^2, 6 degrees of freedom, 99 %

/// A doubtful link with the true motion between two stations, off by what its information states.
PoseGraphLink DoubtfulLink(const SyntheticNetwork& network, std::uint64_t seed, int source,
                           int target) {
  const PoseGraphLink exact = MakeNetwork(seed, 2, 0.0, 0.0).links[0];
  PoseGraphLink link = MakeNetwork(seed, 2, 0.0, 1.0).links[0];
  const Vector6d error = LocalDifference(link.target_from_source, exact.target_from_source);
  link.source = source, link.target = target;
  link.target_from_source =
      Retract(network.survey_from_station[static_cast<std::size_t>(target)].Inverse() *
                  network.survey_from_station[static_cast<std::size_t>(source)],
              error);
  link.doubtful = true;
  return link;
}

/// Accepted chains of three stations each, between which nothing is accepted.
SyntheticNetwork ChainsOfThree(std::uint64_t seed, int chains) {
  SyntheticNetwork network = MakeNetwork(seed, 3 * chains, 0.0, 1.0);
  std::erase_if(network.links,
                [](const PoseGraphLink& link) { return link.source / 3 != link.target / 3; });
  return network;
}

std::vector<int> LoopsOf(const SyntheticNetwork& network,
                         const std::vector<PoseGraphLink>& doubtful, double limit = kLimit) {
  std::vector<PoseGraphLink> links = network.links;
  links.insert(links.end(), doubtful.begin(), doubtful.end());
  const auto stations = static_cast<int>(network.survey_from_station.size());
  const std::vector<int> loops = CountPartLoops(stations, links, limit);
  for (std::size_t l = 0; l < network.links.size(); ++l) EXPECT_EQ(loops[l], 0);
  return {loops.end() - static_cast<std::ptrdiff_t>(doubtful.size()), loops.end()};
}

TEST(CountPartLoops, LinksBetweenTwoPartsSpeakForEachOther) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SyntheticNetwork network = ChainsOfThree(seed, 2);
    std::vector<PoseGraphLink> doubtful = {DoubtfulLink(network, 3 * seed + 100, 0, 5),
                                           DoubtfulLink(network, 3 * seed + 101, 4, 1),
                                           DoubtfulLink(network, 3 * seed + 102, 2, 3)};
    EXPECT_EQ(LoopsOf(network, doubtful, 30.0), (std::vector<int>{2, 2, 2}));
    // A metre beside its place, as a repeated facade would have it.
    doubtful[1].target_from_source.translation.x() += 1.0;
    EXPECT_EQ(LoopsOf(network, doubtful, 30.0), (std::vector<int>{1, 0, 1}));
  }
}

TEST(CountPartLoops, ALoopLeadsOverThreeOrFourParts) {
  for (const int parts : {3, 4, 5}) {
    const SyntheticNetwork network = ChainsOfThree(7, parts);
    std::vector<PoseGraphLink> ring;
    for (int p = 0; p < parts; ++p) {
      ring.push_back(DoubtfulLink(network, 200 + static_cast<std::uint64_t>(p), 3 * p + 2,
                                  (3 * p + 3) % (3 * parts)));
    }
    const std::vector<int> loops(ring.size(), parts <= 4 ? 1 : 0);
    EXPECT_EQ(LoopsOf(network, ring), loops) << parts << " parts";
    ring[1].target_from_source.translation.y() += 1.0;
    EXPECT_EQ(LoopsOf(network, ring), std::vector<int>(ring.size(), 0)) << parts << " parts";
  }
}

TEST(CountPartLoops, TrueLoopsCloseAsOftenAsStated) {
  int closed = 0;
  constexpr int kSeeds = 300;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SyntheticNetwork network = ChainsOfThree(seed, 2);
    const std::vector<int> loops = LoopsOf(network, {DoubtfulLink(network, 2 * seed + 1000, 0, 5),
                                                     DoubtfulLink(network, 2 * seed + 1001, 2, 3)});
    closed += loops[0];
    EXPECT_EQ(loops[0], loops[1]);
  }
  // 99 % or, where both ways within a part have links in common, more.
  EXPECT_GE(closed, 0.97 * kSeeds);
}

TEST(CountPartLoops, VagueAndHardlyCredibleLinksAreNotAsked) {
  const SyntheticNetwork network = ChainsOfThree(3, 2);
  const std::vector<PoseGraphLink> sure = {DoubtfulLink(network, 300, 0, 5),
                                           DoubtfulLink(network, 301, 4, 1)};
  ASSERT_EQ(LoopsOf(network, sure), (std::vector<int>{1, 1}));
  std::vector<PoseGraphLink> links = sure;
  links[0].credibility = 0.4;
  EXPECT_EQ(LoopsOf(network, links), (std::vector<int>{0, 0}));
  links = sure;
  links[1].information.row(3).setZero();  // slides along one axis
  links[1].information.col(3).setZero();
  EXPECT_EQ(LoopsOf(network, links), (std::vector<int>{0, 0}));
}

TEST(CountPartLoops, RivalsOfOnePairAreOneWitness) {
  const SyntheticNetwork network = ChainsOfThree(5, 2);
  const PoseGraphLink one = DoubtfulLink(network, 400, 0, 5);
  const PoseGraphLink same_pair = DoubtfulLink(network, 401, 0, 5);
  const PoseGraphLink other = DoubtfulLink(network, 402, 4, 1);
  EXPECT_EQ(LoopsOf(network, {one, same_pair, other}), (std::vector<int>{1, 1, 1}));
  EXPECT_EQ(LoopsOf(network, {one, same_pair}), (std::vector<int>{0, 0}));
}

TEST(CountPartLoops, NothingDoubtfulNoLoops) {
  EXPECT_TRUE(LoopsOf(ChainsOfThree(1, 2), {}).empty());
}

}  // namespace
}  // namespace backsight
