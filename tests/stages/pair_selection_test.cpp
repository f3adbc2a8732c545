#include "stages/pair_selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/random.h"
#include "stages/link_structure.h"

namespace backsight {
namespace {

std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// Stations at random places of a square; pairs closer than 1 can be registered. The ranking sees
/// the distance through noise.
struct World {
  std::vector<Eigen::Vector2d> places;
  std::vector<PairProspect> candidates;
  std::vector<char> detectable;
  int full = 0;
  int predicted = 0;
  int thorough = 0;                  ///< none finds anything: the worst case
  std::vector<double> when_matched;  ///< similarity of the candidates that begin unmatched
  bool twice = false;
  std::vector<std::size_t> order;  ///< of all registrations

  double Distance(const PairProspect& pair) const {
    return (places[At(pair.source)] - places[At(pair.target)]).norm();
  }
  int stations() const { return static_cast<int>(places.size()); }
};

/// `mean_neighbors` within reach of a station; full registrations of reachable pairs succeed with
/// probability `success`.
World MakeWorld(std::uint64_t seed, int stations, double mean_neighbors, double noise,
                double success) {
  Random random(seed);
  World world;
  const double edge = std::sqrt(stations * 3.14159 / mean_neighbors);
  for (int s = 0; s < stations; ++s) {
    world.places.emplace_back(random.Uniform(0.0, edge), random.Uniform(0.0, edge));
  }
  for (int t = 0; t < stations; ++t) {
    for (int s = t + 1; s < stations; ++s) {
      PairProspect pair;
      pair.source = s, pair.target = t;
      pair.similarity = -world.Distance(pair) + noise * random.Normal();
      world.candidates.push_back(pair);
      world.detectable.push_back(world.Distance(pair) < 1.0 && random.Uniform() < success ? 1 : 0);
    }
  }
  return world;
}

/// Components of the graph of detectable, allowed pairs.
std::vector<int> TrueComponents(const World& world) {
  std::vector<PairProspect> truth = world.candidates;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].accepted =
        world.detectable[i] != 0 && !truth[i].excluded && (!truth[i].too_far || truth[i].required);
  }
  return FindLinkStructure(world.stations(), truth).component;
}

/// Registers what is asked for until nothing is; predictions come from the true places.
void Play(const PairSelectionOptions& options, World* world) {
  while (true) {
    const LinkStructure structure = FindLinkStructure(world->stations(), world->candidates);
    for (PairProspect& pair : world->candidates) {
      pair.predicted_overlap.reset();
      if (structure.component[At(pair.source)] != structure.component[At(pair.target)]) continue;
      pair.predicted_overlap = std::max(0.0, 1.0 - 0.8 * world->Distance(pair));
    }
    const PairBatch batch = NextPairs(world->stations(), world->candidates, options);
    for (const std::size_t i : batch.to_match) {
      PairProspect& pair = world->candidates.at(i);
      EXPECT_TRUE(pair.unmatched);
      EXPECT_NE(structure.component[At(pair.source)], structure.component[At(pair.target)]);
      pair.similarity = world->when_matched[i];
      pair.unmatched = false;
    }
    EXPECT_TRUE(batch.to_match.empty() || batch.pairs.empty());
    if (batch.pairs.empty() && batch.to_match.empty()) return;
    for (const std::size_t i : batch.pairs) {
      PairProspect& pair = world->candidates.at(i);
      const bool full = batch.method == PairMethod::kFull;
      const bool predicted = batch.method == PairMethod::kPredicted;
      bool& tried = full ? pair.tried_full : predicted ? pair.tried_predicted : pair.tried_thorough;
      world->twice = world->twice || tried || pair.accepted;
      tried = true;
      if (full) pair.accepted = world->detectable[i] != 0;
      if (predicted) pair.accepted = world->Distance(pair) < 1.0;
      (full ? world->full : predicted ? world->predicted : world->thorough) += 1;
      world->order.push_back(i);
    }
  }
}

TEST(PairSelection, ConnectsWhateverCanBeConnectedWithAFewRegistrationsPerStation) {
  for (const int stations : {13, 30, 60, 120, 200}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      World world = MakeWorld(seed, stations, 9.0, 0.3, 0.8);
      Play({}, &world);
      const LinkStructure found = FindLinkStructure(stations, world.candidates);
      EXPECT_EQ(found.component, TrueComponents(world)) << stations << " stations, seed " << seed;
      EXPECT_LE(world.full + world.thorough, 8 * stations);
      EXPECT_LE(world.predicted, 10 * stations) << "grows like n";
      EXPECT_FALSE(world.twice);
    }
  }
}

TEST(PairSelection, FiveHundredStationsConnectWithinTheBudget) {
  World world = MakeWorld(5, 500, 12.0, 0.5, 0.7);
  Play({}, &world);
  EXPECT_EQ(FindLinkStructure(500, world.candidates).component, TrueComponents(world));
  EXPECT_LE(world.full + world.thorough, 8 * 500);
}

TEST(PairSelection, SmallCampaignsRegisterEveryPairOnceAndPredictWhatFailed) {
  for (int stations = 2; stations <= 12; ++stations) {
    World world = MakeWorld(3, stations, 4.0, 0.3, 0.8);
    Play({}, &world);
    EXPECT_EQ(world.full, stations * (stations - 1) / 2);
    EXPECT_FALSE(world.twice);
    for (const PairProspect& pair : world.candidates) {
      const bool wanted = pair.predicted_overlap.value_or(0.0) >= 0.2;
      EXPECT_TRUE(pair.accepted || pair.tried_predicted || !wanted);
    }
  }
}

TEST(PairSelection, AUselessRankingNeverBreaksTheBudgetAndLeavesReasons) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    World world = MakeWorld(seed, 80, 8.0, /*noise=*/1000.0, 0.8);
    Play({}, &world);
    EXPECT_LE(world.full + world.thorough, 8 * 80);
    for (const PairProspect& pair : world.candidates) {
      EXPECT_EQ(SkipReason(pair, {}).empty(), pair.tried_full || pair.tried_predicted);
    }
  }
}

TEST(PairSelection, UntilConnectedGoesOnToTheLastPair) {
  World world = MakeWorld(2, 60, 8.0, /*noise=*/1000.0, 0.5);
  PairSelectionOptions options;
  options.until_connected = true;
  Play(options, &world);
  EXPECT_EQ(FindLinkStructure(60, world.candidates).component, TrueComponents(world));
}

/// All pairs of the first stations with others are taken for hopeless, which some are not.
World WithHiddenStations(std::uint64_t seed, int stations, int hidden) {
  World world = MakeWorld(seed, stations, 9.0, 0.3, 0.9);
  for (PairProspect& pair : world.candidates) {
    world.when_matched.push_back(pair.similarity);
    if (pair.target >= hidden) continue;
    pair.unmatched = true;
    pair.similarity -= 1000.0 + 5.0 * static_cast<double>((7 * pair.source + pair.target) % 100);
  }
  return world;
}

TEST(PairSelection, UnmatchedPairsBetweenComponentsAreRankedBeforeTheBudgetIsSpent) {
  int apart_without = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    World world = WithHiddenStations(seed, 150, 20);
    World unranked = world;
    Play({}, &world);
    EXPECT_EQ(FindLinkStructure(150, world.candidates).component, TrueComponents(world));
    EXPECT_LE(world.full + world.thorough, 8 * 150);

    PairSelectionOptions options;
    options.matched_per_station = 0;
    Play(options, &unranked);
    apart_without +=
        FindLinkStructure(150, unranked.candidates).component != TrueComponents(unranked) ? 1 : 0;
  }
  EXPECT_GT(apart_without, 0) << "else nothing was hidden";
}

std::ptrdiff_t Matched(const World& world) {
  return std::count_if(world.candidates.begin(), world.candidates.end(),
                       [](const PairProspect& pair) { return !pair.unmatched; });
}

TEST(PairSelection, NoMoreIsMatchedThanAllowed) {
  World world = WithHiddenStations(1, 150, 20);
  const auto before = Matched(world);
  PairSelectionOptions options;
  options.matched_per_station = static_cast<int>(before / 150) + 2;
  Play(options, &world);
  EXPECT_GT(Matched(world), before);
  EXPECT_LE(Matched(world), 150 * options.matched_per_station);
}

/// Of each station only `matched` pairs are ranked by what the clouds say, those that a guess as
/// wrong as `noise` takes for its best.
World WithGuesses(std::uint64_t seed, int stations, int matched, double noise) {
  World world = MakeWorld(seed, stations, 9.0, 0.1, 0.95);
  Random random(seed + 100);
  std::vector<std::pair<double, std::size_t>> guesses;
  for (std::size_t i = 0; i < world.candidates.size(); ++i) {
    PairProspect& pair = world.candidates[i];
    world.when_matched.push_back(pair.similarity);
    pair.unmatched = true;
    pair.similarity += noise * random.Normal() - 1000.0;
    guesses.emplace_back(-pair.similarity, i);
  }
  std::sort(guesses.begin(), guesses.end());
  std::vector<int> taken(At(stations), 0);
  for (const auto& [guess, i] : guesses) {
    PairProspect& pair = world.candidates[i];
    if (std::min(taken[At(pair.source)], taken[At(pair.target)]) >= matched) continue;
    ++taken[At(pair.source)], ++taken[At(pair.target)];
    pair.unmatched = false;
    pair.similarity = world.when_matched[i];
  }
  return world;
}

TEST(PairSelection, FailuresHaveFurtherPairsRankedInsteadOfTried) {
  int full = 0;
  int full_without = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    World world = WithGuesses(seed, 150, 10, /*noise=*/4.0);
    World without = world;
    Play({}, &world);
    EXPECT_EQ(FindLinkStructure(150, world.candidates).component, TrueComponents(world));
    full += world.full;
    PairSelectionOptions options;
    options.matched_per_failure = 0;
    Play(options, &without);
    full_without += without.full;
  }
  EXPECT_LT(full, 0.9 * full_without);
}

TEST(PairSelection, NothingIsRankedWhereNoRegistrationIsLeft) {
  World world = WithGuesses(1, 60, 10, /*noise=*/4.0);
  int spent = 0;
  for (PairProspect& pair : world.candidates) {
    if (spent == 8 * 60) break;
    pair.tried_full = true;
    ++spent;
  }
  const PairBatch batch = NextPairs(60, world.candidates, {});
  EXPECT_TRUE(batch.to_match.empty());
  EXPECT_TRUE(batch.pairs.empty());
}

TEST(PairSelection, WhatSeldomFailsNeedsLittleFurtherRanking) {
  World world = WithGuesses(1, 150, 25, /*noise=*/0.0);
  for (std::size_t i = 0; i < world.candidates.size(); ++i) {
    world.detectable[i] = world.Distance(world.candidates[i]) < 1.0 ? 1 : 0;
  }
  const auto before = Matched(world);
  Play({}, &world);
  const LinkStructure found = FindLinkStructure(150, world.candidates);
  ASSERT_EQ(*std::max_element(found.component.begin(), found.component.end()), 0);
  EXPECT_LE(Matched(world) - before, 150);
}

TEST(PairSelection, TwoGroupsWithoutCommonViewStayApartWithinTheBudget) {
  World world = MakeWorld(7, 60, 10.0, 0.3, 0.9);
  for (std::size_t i = 0; i < world.candidates.size(); ++i) {
    const PairProspect& pair = world.candidates[i];
    if ((pair.source < 30) != (pair.target < 30)) world.detectable[i] = 0;
  }
  Play({}, &world);
  EXPECT_EQ(FindLinkStructure(60, world.candidates).component, TrueComponents(world));
  EXPECT_LE(world.full, 8 * 60);
}

TEST(PairSelection, EveryStationThatCanComesOntoALoopWithThreeLinks) {
  World world = MakeWorld(11, 100, 12.0, 0.3, 0.9);
  Play({}, &world);
  const LinkStructure found = FindLinkStructure(100, world.candidates);
  std::vector<int> reachable(100, 0);
  for (const PairProspect& pair : world.candidates) {
    if (world.Distance(pair) < 0.85) ++reachable[At(pair.source)], ++reachable[At(pair.target)];
  }
  std::vector<int> block_size(100, 0);
  for (const int block : found.block) ++block_size[At(block)];
  for (int s = 0; s < 100; ++s) {
    if (reachable[At(s)] < 3) continue;
    EXPECT_GE(found.links[At(s)], 3) << s;
    EXPECT_GT(block_size[At(found.block[At(s)])], 1) << s;
  }
}

TEST(PairSelection, ExcludedPairsAreNeverTriedRequiredOnesAlwaysAndFirst) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    World world = MakeWorld(seed, 40, 9.0, 0.3, 0.8);
    Random random(seed);
    std::size_t required = 0;
    for (PairProspect& pair : world.candidates) {
      const double draw = random.Uniform();
      pair.excluded = draw < 0.1;
      pair.required = draw > 0.98;
      pair.too_far = random.Uniform() < 0.2;
      required += pair.required ? 1 : 0;
    }
    Play({}, &world);
    for (std::size_t i = 0; i < world.candidates.size(); ++i) {
      const PairProspect& pair = world.candidates[i];
      if (pair.excluded || (pair.too_far && !pair.required)) {
        EXPECT_FALSE(pair.tried_full || pair.tried_predicted);
        EXPECT_EQ(SkipReason(pair, {}), pair.excluded ? "excluded" : "prior_too_far");
      }
      EXPECT_TRUE(pair.tried_full || !pair.required);
    }
    for (std::size_t k = 0; k < required; ++k) {
      EXPECT_TRUE(world.candidates[world.order[k]].required);
    }
    EXPECT_FALSE(world.twice);
  }
}

TEST(PairSelection, CertainPairsAreRegisteredWhateverTheOthersGive) {
  for (const int stations : {6, 12, 13, 25}) {
    std::size_t certain = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      World world =
          MakeWorld(seed, stations, 5.0, 0.5, /*success=*/static_cast<double>(seed) / 6.0);
      Random random(seed);
      for (PairProspect& pair : world.candidates) {
        pair.required = random.Uniform() < 0.05;
        pair.excluded = random.Uniform() < 0.1;
        pair.too_far = random.Uniform() < 0.2;
      }
      const std::vector<PairProspect> before = world.candidates;
      Play({}, &world);
      for (std::size_t i = 0; i < before.size(); ++i) {
        const PairProspect& after = world.candidates[i];
        if (IsCertain(before[i], stations, {})) {
          EXPECT_TRUE(after.tried_full);
          ++certain;
        } else if (stations <= 12) {
          EXPECT_FALSE(after.tried_full) << "nothing is uncertain where all pairs are tried";
        }
        EXPECT_FALSE(IsCertain(after, stations, {})) << "it was tried, or never may be";
      }
    }
    EXPECT_GT(certain, 10U) << stations;
  }
}

TEST(PairSelection, EqualKnowledgeGivesEqualPairs) {
  World a = MakeWorld(9, 70, 9.0, 0.3, 0.8);
  World b = a;
  Play({}, &a);
  Play({}, &b);
  EXPECT_EQ(a.order, b.order);
}

TEST(PairSelection, StationsWithoutCandidatesPlayNoPart) {
  World world = MakeWorld(4, 40, 9.0, 0.3, 0.8);
  std::erase_if(world.candidates,
                [](const PairProspect& pair) { return pair.source == 39 || pair.target == 39; });
  world.detectable.assign(world.candidates.size(), 0);
  Play({}, &world);
  EXPECT_EQ(world.full + world.thorough, std::min<int>(8 * 39, 39 * 38 / 2));
}

TEST(LinkStructure, BlocksAreWhatSurvivesTheLossOfAnyLink) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    World world = MakeWorld(seed, 14, 4.0, 0.0, 1.0);
    for (std::size_t i = 0; i < world.candidates.size(); ++i) {
      world.candidates[i].accepted = random.Uniform() < 0.12;
    }
    const LinkStructure structure = FindLinkStructure(14, world.candidates);
    for (const PairProspect& asked : world.candidates) {
      bool together =
          structure.component[At(asked.source)] == structure.component[At(asked.target)];
      for (std::size_t lost = 0; lost < world.candidates.size(); ++lost) {
        if (!world.candidates[lost].accepted) continue;
        std::vector<PairProspect> rest = world.candidates;
        rest[lost].accepted = false;
        const auto component = FindLinkStructure(14, rest).component;
        together = together && component[At(asked.source)] == component[At(asked.target)];
      }
      EXPECT_EQ(structure.block[At(asked.source)] == structure.block[At(asked.target)], together);
    }
  }
}

}  // namespace
}  // namespace backsight
