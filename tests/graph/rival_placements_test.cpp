#include "graph/rival_placements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

std::vector<char> TrueLinks(const SyntheticNetwork& network) {
  std::vector<char> used;
  for (std::size_t l = 0; l < network.links.size(); ++l) used.push_back(l % 2 == 0 ? 1 : 0);
  return used;
}

std::vector<RivalPlacement> Find(const SyntheticNetwork& network, const std::vector<char>& used,
                                 const RivalOptions& options) {
  const std::vector<char> eligible(network.links.size(), 1);
  return FindRivalPlacements(network.links, eligible, used, network.survey_from_station, options);
}

/// Margin less noise of turning the stations of `set` in a hall whose true links are used.
double Excess(const SyntheticNetwork& hall, unsigned set, double score_noise) {
  double margin = 0.0;
  int pairs = 0;
  for (std::size_t l = 0; l < hall.links.size(); l += 2) {
    const PoseGraphLink& link = hall.links[l];
    if ((set >> static_cast<unsigned>(link.source) & 1U) ==
        (set >> static_cast<unsigned>(link.target) & 1U)) {
      continue;
    }
    margin += std::clamp((link.score - hall.links[l + 1].score) / (std::sqrt(2.0) * score_noise),
                         -kFullVote, kFullVote);
    ++pairs;
  }
  return margin - 3.0 * std::sqrt(static_cast<double>(pairs));
}

TEST(FindRivalPlacements, FindsTheLeastCertainTurnOfAHall) {
  // Against all 2^(n-1) ways to turn stations. Some pairs have no turned rival.
  int equal = 0;
  constexpr int kSeeds = 60;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const int stations = 4 + static_cast<int>(seed % 5);
    const auto hall = MakeHall(seed, stations, 0.03, 0.02);
    const auto found = Find(hall, TrueLinks(hall), {});
    ASSERT_EQ(found.size(), 1U);
    double best = 1e300;
    for (unsigned set = 1; set < (1U << static_cast<unsigned>(stations)) - 1U; ++set) {
      best = std::min(best, Excess(hall, set, 0.02));
    }
    const double actual = found[0].margin - found[0].noise;
    EXPECT_GE(actual, best - 1e-9);
    equal += actual < best + 1e-9 ? 1 : 0;
    unsigned set = 0;
    for (const int s : found[0].stations) set |= 1U << static_cast<unsigned>(s);
    EXPECT_NEAR(Excess(hall, set, 0.02), actual, 1e-9) << "it is what it says";
  }
  EXPECT_GE(equal, kSeeds * 9 / 10) << "greedy growth may miss a few";
}

TEST(FindRivalPlacements, NoneWhereAllAgree) {
  const auto network = MakeTown(1, 16, 6, 1.0);
  EXPECT_TRUE(Find(network, std::vector<char>(network.links.size(), 1), {}).empty());
}

TEST(FindRivalPlacements, LoneOutliersAreNone) {
  auto network = MakeTown(2, 16, 8, 1.0);
  const auto is_false = FalsifyLinks(2, 0.2, &network.links);
  std::vector<char> used;
  for (const char f : is_false) used.push_back(f == 0 ? 1 : 0);
  EXPECT_TRUE(Find(network, used, {}).empty());
}

/// Station 3 hangs by one used link; its other link, not used, would have it `shift_m` elsewhere.
SyntheticNetwork HangingStation(double shift_m, bool doubtful, double credibility,
                                std::vector<char>* used) {
  auto network = MakeNetwork(3, 4, 1.0, 1.0);
  std::erase_if(network.links, [](const PoseGraphLink& link) {
    return std::minmax(link.source, link.target) == std::minmax(1, 3);
  });
  for (PoseGraphLink& link : network.links) {
    const bool shifted = std::minmax(link.source, link.target) == std::minmax(0, 3);
    if (shifted) {
      link = Displaced(link, network, {Eigen::Matrix3d::Identity(), {shift_m, 0.0, 0.0}});
      link.doubtful = doubtful;
      link.credibility = credibility;
    }
    used->push_back(shifted ? 0 : 1);
  }
  return network;
}

TEST(FindRivalPlacements, AStationOfOneLinkAgainstAnotherIsUndecided) {
  std::vector<char> used;
  const auto network = HangingStation(4.0, false, 1.0, &used);
  const auto found = Find(network, used, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kept, 1);
  EXPECT_EQ(found[0].links.size(), 1U);
  EXPECT_TRUE(found[0].Undecided());
  EXPECT_NEAR(found[0].displacement.translation.norm(), 4.0, 0.05);
}

TEST(FindRivalPlacements, ASingleDoubtfulLinkNeedsCredibility) {
  for (const double credibility : {0.0, 0.3, 0.6, 1.0}) {
    std::vector<char> used;
    const auto network = HangingStation(4.0, true, credibility, &used);
    EXPECT_EQ(Find(network, used, {}).size(), credibility >= kLeastCredibility ? 1U : 0U)
        << credibility;
  }
}

TEST(FindRivalPlacements, APoorMeasurementOfTheSamePlaceIsNone) {
  for (const double shift_m : {0.15, 0.25}) {
    std::vector<char> used;
    const auto network = HangingStation(shift_m, false, 1.0, &used);
    EXPECT_EQ(Find(network, used, {}).size(), shift_m < 0.2 ? 0U : 1U) << shift_m;
  }
}

TEST(FindRivalPlacements, CountsLinksForAndAgainstAShiftedStation) {
  // Station 5 of a full network: two of its five links are one bay off, not used.
  auto network = MakeNetwork(4, 6, 1.0, 1.0);
  const RigidTransform bay{Eigen::Matrix3d::Identity(), {4.0, 0.0, 0.0}};
  std::vector<char> used;
  int left = 2;
  for (PoseGraphLink& link : network.links) {
    const bool of_five = std::max(link.source, link.target) == 5;
    const bool shift = of_five && left-- > 0;
    if (shift) {
      const bool source_moves = link.source == 5;
      link = Displaced(link, network, source_moves ? bay : bay.Inverse());
    }
    used.push_back(shift ? 0 : 1);
  }
  const auto found = Find(network, used, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kept, 3);
  EXPECT_EQ(found[0].links.size(), 2U);
  EXPECT_DOUBLE_EQ(found[0].margin, kFullVote);
  EXPECT_TRUE(found[0].Undecided()) << "three against two is not enough";

  for (std::size_t l = 0; l < used.size(); ++l) {
    if (used[l] == 0) network.links[l].credibility = 0.1;
  }
  const auto hardly = Find(network, used, {});
  ASSERT_EQ(hardly.size(), 1U);
  EXPECT_DOUBLE_EQ(hardly[0].margin, (3.0 - 2.0 * 0.1) * kFullVote);
  EXPECT_FALSE(hardly[0].Undecided()) << "what is hardly credible does not count as much";
}

}  // namespace
}  // namespace backsight
