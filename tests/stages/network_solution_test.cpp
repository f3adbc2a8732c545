#include "stages/network_solution.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <set>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

/// Without a floor under the errors: those of synthetic networks are what they say.
NetworkOptions Exact() {
  NetworkOptions options;
  options.floor_rotation_deg = 0.0;
  options.floor_translation_m = 0.0;
  return options;
}

std::vector<NetworkLink> ToNetworkLinks(const std::vector<PoseGraphLink>& links) {
  std::vector<NetworkLink> result;
  for (std::size_t l = 0; l < links.size(); ++l) {
    const PoseGraphLink& link = links[l];
    NetworkLink made;
    made.pair = link.pair >= 0 ? link.pair : static_cast<int>(l);
    made.source = link.source;
    made.target = link.target;
    made.target_from_source = link.target_from_source;
    made.information = link.information;
    made.confidence = link.confidence;
    made.score = link.score;
    made.doubtful = link.doubtful;
    result.push_back(made);
  }
  return result;
}

NetworkResult Solve(const SyntheticNetwork& network, const NetworkOptions& options = Exact()) {
  return SolveNetwork(static_cast<int>(network.survey_from_station.size()),
                      ToNetworkLinks(network.links), options);
}

double LargestDistance(const std::vector<RigidTransform>& a, const std::vector<RigidTransform>& b) {
  double largest = 0.0;
  for (std::size_t s = 0; s < a.size(); ++s) {
    largest = std::max(largest, (a[s].translation - b[s].translation).norm());
  }
  return largest;
}

SyntheticNetwork Without(const SyntheticNetwork& network, const std::vector<char>& leave_out) {
  SyntheticNetwork rest = network;
  rest.links.clear();
  for (std::size_t l = 0; l < network.links.size(); ++l) {
    if (leave_out[l] == 0) rest.links.push_back(network.links[l]);
  }
  return rest;
}

int Count(const NetworkResult& result, LinkFate fate) {
  return static_cast<int>(std::count(result.fate.begin(), result.fate.end(), fate));
}

TEST(SolveNetwork, ThirtyPercentFalseLinksChangeNothing) {
  for (const int stations : {8, 15, 30, 60}) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      // Everyone with everyone where there are few; a town where there are many.
      auto network =
          stations < 15 ? MakeNetwork(seed, stations, 1.0, 1.0) : MakeTown(seed, stations, 12, 1.0);
      const auto is_false = ReplaceByRandom(seed + 50, 0.3, &network.links);
      const auto with = Solve(network);
      const auto without = Solve(Without(network, is_false));
      EXPECT_EQ(with.poses.component, without.poses.component);
      EXPECT_LT(LargestDistance(with.poses.survey_from_station, without.poses.survey_from_station),
                1e-3)
          << stations << " stations, seed " << seed;
      for (std::size_t l = 0; l < is_false.size(); ++l) {
        if (is_false[l] != 0) {
          EXPECT_NE(with.fate[l], LinkFate::kUsed) << seed << " link " << l;
        }
      }
    }
  }
}

TEST(SolveNetwork, NoFalseLinkIsEverUsedHoweverThinTheNetwork) {
  // Sparse networks: true links may be lost, false ones must not come in where a loop denies them.
  int placed = 0;
  int all = 0;
  int uncontrolled = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    auto network = MakeTown(seed, 20, 5, 1.0);
    const auto is_false = ReplaceByRandom(seed + 50, 0.15, &network.links);
    const auto result = Solve(network);
    for (std::size_t l = 0; l < is_false.size(); ++l) {
      if (is_false[l] == 0 || result.fate[l] != LinkFate::kUsed) continue;
      EXPECT_FALSE(result.loop_controlled[l]) << seed << " link " << l;
      ++uncontrolled;
    }
    for (const int c : result.poses.component) placed += c == 0 ? 1 : 0;
    all += 20;
  }
  std::printf("placed in the first component: %d of %d; false and uncontrolled: %d\n", placed, all,
              uncontrolled);
  EXPECT_EQ(uncontrolled, 0);
  EXPECT_GT(placed, all * 8 / 10);
}

TEST(SolveNetwork, TwoComponentsStayTwo) {
  const auto a = MakeNetwork(3, 4, 1.0, 1.0);
  auto b = MakeNetwork(4, 5, 1.0, 1.0);
  SyntheticNetwork both = a;
  both.survey_from_station.resize(10);
  for (PoseGraphLink link : b.links) {
    link.source += 4, link.target += 4;
    both.links.push_back(link);
  }
  const auto result = Solve(both);
  EXPECT_EQ(result.poses.component, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1, 1, 2}));
  EXPECT_EQ(result.redundancy, 6 * (6 + 10 - 3 - 4));
  for (const std::size_t s : {0U, 4U, 9U}) {
    EXPECT_EQ(result.poses.covariance[s].norm(), 0.0);
    EXPECT_EQ(result.poses.survey_from_station[s].Matrix(), Eigen::Matrix4d::Identity().eval());
  }
}

TEST(SolveNetwork, AFalseBridgeThatALoopContradictsGoes) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    // Two parts of four, joined by three true links and a false one that looks best.
    auto network = MakeNetwork(seed, 8, 1.0, 1.0);
    const std::set<std::pair<int, int>> joins{{0, 4}, {1, 5}, {2, 6}, {3, 7}};
    std::erase_if(network.links, [&](const PoseGraphLink& link) {
      return (link.source < 4) != (link.target < 4) &&
             !joins.contains(std::minmax(link.source, link.target));
    });
    std::size_t bridge = 0;
    for (std::size_t l = 0; l < network.links.size(); ++l) {
      PoseGraphLink& link = network.links[l];
      if (std::minmax(link.source, link.target) != std::minmax(3, 7)) continue;
      Random random(seed);
      link.target_from_source = RandomTransform(random, 20.0);
      link.confidence = 100.0;
      bridge = l;
    }
    const auto result = Solve(network);
    EXPECT_EQ(result.fate[bridge], LinkFate::kContradictsNetwork);
    EXPECT_EQ(Count(result, LinkFate::kUsed), static_cast<int>(network.links.size()) - 1);
    EXPECT_LT(LargestDistance(result.poses.survey_from_station, network.survey_from_station), 0.05);
  }
}

TEST(SolveNetwork, TwoBridgesThatContradictEachOtherAreBothLeftOut) {
  auto network = MakeNetwork(1, 8, 1.0, 1.0);
  std::erase_if(network.links, [&](const PoseGraphLink& link) {
    return (link.source < 4) != (link.target < 4) &&
           std::minmax(link.source, link.target) != std::minmax(0, 4) &&
           std::minmax(link.source, link.target) != std::minmax(1, 5);
  });
  for (PoseGraphLink& link : network.links) {
    if (std::minmax(link.source, link.target) != std::minmax(1, 5)) continue;
    link = Displaced(link, network, {Eigen::Matrix3d::Identity(), {4.0, 0.0, 0.0}});
  }
  const auto result = Solve(network);
  EXPECT_EQ(result.poses.component, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(Count(result, LinkFate::kAmbiguous), 2);
  ASSERT_EQ(result.ambiguities.size(), 1U);
  EXPECT_EQ(result.ambiguities[0].stations, (std::vector<int>{4, 5, 6, 7}));
  EXPECT_NEAR(result.ambiguities[0].shift_m, 4.0, 0.05);
}

TEST(SolveNetwork, ARingThatDoesNotCloseFallsApart) {
  // Which of its links is false nobody can know; none may stay.
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    auto network = MakeNetwork(seed, 7, 0.0, 1.0);
    PoseGraphLink closing = network.links[0];
    closing.source = 6, closing.target = 0;
    closing.target_from_source = network.survey_from_station[6];
    network.links.push_back(closing);
    EXPECT_EQ(Count(Solve(network), LinkFate::kUsed), 7);
    PoseGraphLink& link = network.links[seed];
    link = Displaced(link, network, {Eigen::Matrix3d::Identity(), {4.0, 0.0, 0.0}});
    EXPECT_EQ(Count(Solve(network), LinkFate::kAmbiguous), 7) << seed;
  }
}

TEST(SolveNetwork, TheOrderOfTheLinksDoesNotMatter) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    auto network = MakeTown(seed, 25, 8, 1.0);
    ReplaceByRandom(seed, 0.3, &network.links);
    SyntheticNetwork shuffled = network;
    std::vector<std::size_t> order;
    for (std::size_t l = 0; l < network.links.size(); ++l) order.push_back(l);
    Random random(seed);
    for (std::size_t l = order.size(); l-- > 1;) std::swap(order[l], order[random.Index(l + 1)]);
    for (std::size_t l = 0; l < order.size(); ++l) shuffled.links[l] = network.links[order[l]];
    const auto a = Solve(network);
    const auto b = Solve(shuffled);
    for (std::size_t l = 0; l < order.size(); ++l) EXPECT_EQ(b.fate[l], a.fate[order[l]]);
    EXPECT_LT(LargestDistance(a.poses.survey_from_station, b.poses.survey_from_station), 1e-7);
  }
}

TEST(SolveNetwork, ABridgeIsUsedAndMarkedUnlessItIsDoubtful) {
  auto network = MakeNetwork(2, 8, 1.0, 1.0);
  std::erase_if(network.links, [&](const PoseGraphLink& link) {
    return (link.source < 4) != (link.target < 4) &&
           std::minmax(link.source, link.target) != std::minmax(2, 5);
  });
  const auto bridge =
      static_cast<std::size_t>(std::find_if(network.links.begin(), network.links.end(),
                                            [](const PoseGraphLink& link) {
                                              return (link.source < 4) != (link.target < 4);
                                            }) -
                               network.links.begin());
  const auto accepted = Solve(network);
  for (std::size_t l = 0; l < network.links.size(); ++l) {
    EXPECT_EQ(accepted.fate[l], LinkFate::kUsed);
    EXPECT_EQ(accepted.loop_controlled[l], l != bridge);
  }
  network.links[bridge].doubtful = true;
  const auto doubtful = Solve(network);
  EXPECT_EQ(doubtful.fate[bridge], LinkFate::kUnconfirmed);
  EXPECT_EQ(doubtful.poses.component, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1}));
}

TEST(SolveNetwork, DoubtfulLinksAreUsedWhereLoopsConfirmThem) {
  auto network = MakeNetwork(3, 5, 1.0, 1.0);
  network.links[0].doubtful = true;
  const auto one = Solve(network);
  EXPECT_EQ(Count(one, LinkFate::kUsed), 10) << "the others are accepted and agree with it";

  // All doubtful: each has other ways around.
  for (PoseGraphLink& link : network.links) link.doubtful = true;
  const auto all = Solve(network);
  EXPECT_EQ(Count(all, LinkFate::kUsed), 10);

  // A triangle of doubtful ones has only one loop for them all.
  auto triangle = MakeNetwork(4, 3, 1.0, 1.0);
  for (PoseGraphLink& link : triangle.links) link.doubtful = true;
  const auto none = Solve(triangle);
  EXPECT_EQ(Count(none, LinkFate::kUnconfirmed), 3);

  // A doubtful false one is not confirmed.
  network = MakeNetwork(5, 6, 1.0, 1.0);
  network.links[3].doubtful = true;
  Random random(5);
  network.links[3].target_from_source = RandomTransform(random, 20.0);
  const auto wrong = Solve(network);
  EXPECT_EQ(wrong.fate[3], LinkFate::kUnconfirmed);
  EXPECT_EQ(Count(wrong, LinkFate::kUsed), 14);
}

TEST(SolveNetwork, SymmetricHallIsDecidedByTheScores) {
  int decided = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const int stations = 4 + static_cast<int>(seed % 7);
    const auto hall = MakeHall(seed, stations, 0.08, 0.02);
    const auto result = Solve(hall);
    for (std::size_t l = 0; l < hall.links.size(); ++l) {
      if (l % 2 == 1) {
        EXPECT_NE(result.fate[l], LinkFate::kUsed) << seed << " link " << l;
      }
    }
    // Chance may leave too little between the scores: refused then, never turned.
    if (!result.ambiguities.empty()) continue;
    ++decided;
    EXPECT_EQ(Count(result, LinkFate::kRivalWon), static_cast<int>(hall.links.size() / 2));
    EXPECT_LT(LargestDistance(result.poses.survey_from_station, hall.survey_from_station), 0.1);
  }
  std::printf("symmetric halls decided: %d of 30\n", decided);
  EXPECT_GE(decided, 25);
}

TEST(SolveNetwork, AmbiguousHallIsNotPlaced) {
  int wrong = 0;
  int used = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto hall = MakeHall(seed, 6, 0.0, 0.02);
    const auto result = Solve(hall);
    for (std::size_t l = 0; l < hall.links.size(); ++l) {
      used += result.fate[l] == LinkFate::kUsed ? 1 : 0;
      if (l % 2 == 1 && result.fate[l] == LinkFate::kUsed) ++wrong;
    }
    EXPECT_FALSE(result.ambiguities.empty());
    EXPECT_GT(Count(result, LinkFate::kAmbiguous), 0);
  }
  std::printf("hall without any difference: %d links used, %d of them turned, of 600 pairs\n", used,
              wrong);
  // Three standard deviations, tried over 31 assignments each.
  EXPECT_LE(wrong, 6);
}

TEST(SolveNetwork, DoubtfulRivalsOfAHallConfirmEachOther) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto hall = MakeHall(seed, 6, 0.1, 0.02);
    for (PoseGraphLink& link : hall.links) link.doubtful = true;
    const auto result = Solve(hall);
    for (std::size_t l = 0; l < hall.links.size(); ++l) {
      EXPECT_EQ(result.fate[l] == LinkFate::kUsed, l % 2 == 0) << seed << " link " << l;
    }
  }
}

/// Shifts the first `count` links of `station` as if it stood one bay further.
void ShiftLinks(int station, int count, SyntheticNetwork* network, std::vector<char>* shifted) {
  const RigidTransform bay{Eigen::Matrix3d::Identity(), {4.0, 0.0, 0.0}};
  shifted->assign(network->links.size(), 0);
  for (std::size_t l = 0; l < network->links.size() && count > 0; ++l) {
    PoseGraphLink& link = network->links[l];
    if (link.source != station && link.target != station) continue;
    link = Displaced(link, *network, link.source == station ? bay : bay.Inverse());
    (*shifted)[l] = 1;
    --count;
  }
}

TEST(SolveNetwork, AConsistentBlockOfFalseLinksDoesNotWinSilently) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (int count = 1; count <= 7; ++count) {
      auto network = MakeNetwork(seed, 9, 1.0, 1.0);
      std::vector<char> shifted;
      ShiftLinks(4, count, &network, &shifted);
      const auto result = Solve(network);
      const bool placed = result.poses.component[4] == 0;
      for (std::size_t l = 0; l < shifted.size(); ++l) {
        // Six of eight are believed; whether they should be no network can tell.
        if (shifted[l] != 0 && count < 6) {
          EXPECT_NE(result.fate[l], LinkFate::kUsed) << count;
        }
      }
      EXPECT_EQ(placed, count <= 2 || count >= 6) << count << " of 8";
      if (placed) continue;
      ASSERT_EQ(result.ambiguities.size(), 1U);
      EXPECT_EQ(result.ambiguities[0].stations, (std::vector<int>{4}));
      EXPECT_NEAR(result.ambiguities[0].shift_m, 4.0, 0.05);
    }
  }
}

TEST(SolveNetwork, NormalisedErrorsAreOne) {
  // With errors as stated, and with all of them three times as large as stated.
  for (const double scale : {1.0, 3.0}) {
    double nees = 0.0;
    double link_nees = 0.0;
    int links = 0;
    double factor = 0.0;
    constexpr int kSeeds = 30;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      auto network = MakeTown(seed, 14, 6, scale);
      for (PoseGraphLink& link : network.links) link.information *= scale * scale;
      const auto result = Solve(network);
      factor += result.sigma_factor / kSeeds;
      const Eigen::Index free = 6 * 13;
      Eigen::VectorXd error(free);
      for (std::size_t s = 1; s < 14; ++s) {
        error.segment<6>(6 * (static_cast<Eigen::Index>(s) - 1)) =
            LocalDifference(result.poses.survey_from_station[s], network.survey_from_station[s]);
      }
      nees += error.dot(result.covariance.bottomRightCorner(free, free).ldlt().solve(error)) /
              static_cast<double>(free * kSeeds);
      for (std::size_t l = 0; l < network.links.size(); ++l) {
        const PoseGraphLink& link = network.links[l];
        const auto relative = [&](const std::vector<RigidTransform>& poses) {
          return poses[static_cast<std::size_t>(link.target)].Inverse() *
                 poses[static_cast<std::size_t>(link.source)];
        };
        const Vector6d off = LocalDifference(relative(result.poses.survey_from_station),
                                             relative(network.survey_from_station));
        link_nees += off.dot(result.link_covariance[l].inverse() * off);
        links += 6;
      }
    }
    std::printf("errors %.0f times as stated: sigma factor %.3f, NEES %.3f, of links %.3f\n", scale,
                factor, nees, link_nees / links);
    EXPECT_GT(nees, 0.8);
    EXPECT_LT(nees, 1.2);
    EXPECT_GT(link_nees / links, 0.8);
    EXPECT_LT(link_nees / links, 1.2);
    EXPECT_NEAR(factor, scale, 0.1 * scale);
  }
}

TEST(SolveNetwork, ClosuresAreThoseOfTheMeasuredTriangles) {
  const auto network = MakeNetwork(6, 5, 1.0, 1.0);
  const auto result = Solve(network);
  EXPECT_EQ(result.closures.size(), 10U);
  for (const TriangleClosure& closure : result.closures) {
    EXPECT_LT(closure.a, closure.b);
    EXPECT_LT(closure.b, closure.c);
    EXPECT_GT(closure.translation_m, 0.0);
    EXPECT_LT(closure.translation_m, 0.2);
  }
}

TEST(SolveNetwork, TheFloorHoldsErrorsUp) {
  const auto network = MakeNetwork(7, 4, 1.0, 0.0);
  auto links = ToNetworkLinks(network.links);
  for (NetworkLink& link : links) link.information *= 1e6;
  NetworkOptions options;
  options.floor_translation_m = 0.002;
  const auto result = SolveNetwork(4, links, options);
  // A full network of four: a station's variance relative to another is half that of a link.
  for (std::size_t s = 1; s < 4; ++s) {
    const Matrix6d& covariance = result.link_covariance[s];
    EXPECT_NEAR(std::sqrt(covariance(5, 5)), 0.002 / std::sqrt(2.0), 4e-4);
  }
}

TEST(SolveNetwork, NotRobustUsesEveryLink) {
  auto network = MakeNetwork(8, 6, 1.0, 1.0);
  ReplaceByRandom(8, 0.2, &network.links);
  network.links[0].doubtful = true;
  NetworkOptions options = Exact();
  options.robust = false;
  const auto result = Solve(network, options);
  EXPECT_EQ(Count(result, LinkFate::kUsed), 15);
}

TEST(SolveNetwork, FewLinks) {
  const auto pair = MakeNetwork(9, 2, 1.0, 1.0);
  const auto result = Solve(pair);
  EXPECT_EQ(result.fate[0], LinkFate::kUsed);
  EXPECT_FALSE(result.loop_controlled[0]);
  EXPECT_EQ(result.sigma_factor, 1.0);
  EXPECT_EQ(result.redundancy, 0);
  EXPECT_EQ(SolveNetwork(0, {}, {}).poses.survey_from_station.size(), 0U);
  const auto alone = SolveNetwork(3, {}, {});
  EXPECT_EQ(alone.poses.component, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(alone.poses.covariance.size(), 3U);
}

TEST(SolveNetwork, InformationThatIsSingularGivesNoFalseCertainty) {
  // Corridor: one link knows nothing of the direction along it.
  auto network = MakeNetwork(10, 3, 0.0, 0.0);
  Vector6d known = Vector6d::Constant(1e6);
  known[3] = 0.0;
  network.links[1].information = known.asDiagonal();
  const auto result = Solve(network);
  EXPECT_NEAR(result.weakest.station_m, 1.0, 0.1) << "the least that is assumed";
  EXPECT_EQ(result.weakest.station, 2);
}

TEST(SolveNetwork, BigTownsAreSolved) {
  for (const auto& [stations, degree] : {std::pair{200, 16}, std::pair{500, 16}}) {
    auto network = MakeTown(11, stations, degree, 1.0);
    const auto is_false = ReplaceByRandom(11, 0.3, &network.links);
    const auto start = std::chrono::steady_clock::now();
    const auto result = Solve(network);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("%d stations, %zu links: %.1f s, %d removed, %d readmitted, %d moves\n", stations,
                network.links.size(), seconds.count(), result.removed, result.readmitted,
                result.moves);
    EXPECT_EQ(result.poses.component, std::vector<int>(static_cast<std::size_t>(stations), 0));
    for (std::size_t l = 0; l < is_false.size(); ++l) {
      EXPECT_EQ(result.fate[l] == LinkFate::kUsed, is_false[l] == 0);
    }
  }
}

}  // namespace
}  // namespace backsight
