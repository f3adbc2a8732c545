#include "pipeline/pair_discovery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include "core/random.h"
#include "pipeline/early_pairs.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/run_summary.h"
#include "stages/features.h"
#include "tests/io/scan_files.h"
#include "tests/support/feature_scene.h"

namespace backsight {
namespace {

/// Bends floor and walls, so that no motion lays them on those of a plain yard.
StationModel Bent(const StationModel& yard) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : yard.leaves.means()) {
    points.emplace_back(p.x() + 0.5 * std::sin(1.7 * p.z() + 1.1 * p.y()),
                        p.y() + 0.5 * std::sin(1.9 * p.z() + 1.4 * p.x()),
                        p.z() + 0.6 * std::sin(1.3 * p.x()) * std::sin(1.6 * p.y()));
  }
  return MakeStation(points, yard.resolution_m());
}

PairDiscovery Discover(const std::vector<Station>& stations, const PairSpec& spec,
                       const SurveyOptions& options, const ExecutionContext& context,
                       const ArtifactStore& store = {}) {
  return DiscoverPairs(PairUnits(stations, options, context, store), spec);
}

/// Looks at two yards that have nothing in common: stations 0 to `first` - 1 at one, the others at
/// the other; each look is turned and shifted, with the voxels falling anew.
struct Yards {
  std::vector<Station> stations;
  std::vector<RigidTransform> yard_from_station;

  Yards(int first, int second) {
    Random random(77);
    const std::vector<StationModel> yards = {MakeYardStation(31, 1.0),
                                             Bent(MakeYardStation(32, 1.0))};
    for (int s = 0; s < first + second; ++s) {
      const StationModel& yard = yards[s < first ? 0 : 1];
      const RigidTransform pose{ExpSo3({0.0, 0.0, random.Uniform(-3.0, 3.0)}),
                                {random.Uniform(-2.0, 2.0), random.Uniform(-2.0, 2.0), 0.03 * s}};
      std::vector<Eigen::Vector3d> points;
      const RigidTransform inverse = pose.Inverse();
      for (const Eigen::Vector3d& mean : yard.leaves.means()) points.push_back(inverse * mean);
      Station& station = stations.emplace_back();
      station.spec.id = "S" + std::to_string(s + 1);
      station.model = MakeStation(points, yard.resolution_m());
      station.model.range_image = RangeImage(Eigen::Vector3d::Zero(), 2.0);
      station.features = ComputeFeatures(station.model, {}, ExecutionContext(1));
      station.features.scanner_credible = false;  // the points were not seen from here
      station.index = std::make_shared<CloudIndex>(station.model);
      station.record.extent_m = 8.0;
      yard_from_station.push_back(pose);
    }
  }

  double Error(const Pair& pair) const {
    const auto pose = [&](int s) { return yard_from_station[static_cast<std::size_t>(s)]; };
    const RigidTransform truth = pose(pair.target).Inverse() * pose(pair.source);
    return (truth.translation - pair.best()->fine.target_from_source.translation).norm() +
           RotationAngle(truth.rotation, pair.best()->fine.target_from_source.rotation);
  }
};

SurveyOptions Growing() {
  SurveyOptions options;
  options.pair_selection.strategy = PairSelectionOptions::kGrow;
  return options;
}

std::vector<std::string> Reasons(const PairDiscovery& discovery) {
  std::vector<std::string> reasons;
  for (const SkippedPair& pair : discovery.skipped) reasons.push_back(pair.reason);
  return reasons;
}

TEST(PairDiscovery, FewStationsAreTriedPairByPair) {
  const Yards yards(3, 0);
  const PairDiscovery found = Discover(yards.stations, {}, {}, ExecutionContext(1));
  ASSERT_EQ(found.pairs.size(), 3U);
  EXPECT_EQ(found.full, 3);
  EXPECT_EQ(found.predicted, 0);
  EXPECT_EQ(found.components, 1);
  for (const Pair& pair : found.pairs) {
    EXPECT_NE(pair.verdict(), Verdict::kRejected);
    EXPECT_LT(yards.Error(pair), 0.01);
  }
}

TEST(PairDiscovery, GrowingLinksWhatBelongsTogetherAndPredictsTheRest) {
  const Yards yards(6, 2);
  const PairDiscovery found = Discover(yards.stations, {}, Growing(), ExecutionContext(1));
  EXPECT_EQ(found.components, 2);
  EXPECT_GT(found.predicted, 0);
  int linked = 0;
  for (const Pair& pair : found.pairs) {
    const bool together = (pair.source < 6) == (pair.target < 6);
    EXPECT_TRUE(together || !pair.accepted());
    if (pair.verdict() == Verdict::kRejected || !together) continue;
    ++linked;
    EXPECT_LT(yards.Error(pair), 0.1) << pair.source << " " << pair.target;
  }
  EXPECT_EQ(linked, 15 + 1) << "all pairs within each yard overlap";
  EXPECT_EQ(found.pairs.size() + found.skipped.size(), 28U);
}

TEST(PairDiscovery, PairsThatNobodyMatchedAreMatchedWhileStationsStayApartAndOnlyOnce) {
  const Yards yards(5, 2);
  SurveyOptions options = Growing();
  options.pair_ranking.prematch_per_station = 0;
  options.pair_selection.full_per_station = 4;
  const TempDir dir;
  const ArtifactStore store(dir.path());
  const PairDiscovery found = Discover(yards.stations, {}, options, ExecutionContext(1), store);
  EXPECT_EQ(found.components, 2);

  const std::string ranking = store.PathOf("network/ranking_1");
  ASSERT_TRUE(std::filesystem::exists(ranking));
  const auto written = std::filesystem::last_write_time(ranking);
  const PairDiscovery again = Discover(yards.stations, {}, options, ExecutionContext(1), store);
  EXPECT_EQ(std::filesystem::last_write_time(ranking), written) << "taken from the store";
  EXPECT_EQ(Reasons(again), Reasons(found));
  EXPECT_EQ(again.full, found.full);
}

TEST(PairDiscovery, TheSamePairsForAnyNumberOfThreads) {
  const Yards yards(5, 2);
  const PairDiscovery one = Discover(yards.stations, {}, Growing(), ExecutionContext(1));
  const PairDiscovery four = Discover(yards.stations, {}, Growing(), ExecutionContext(4));
  ASSERT_EQ(one.pairs.size(), four.pairs.size());
  for (std::size_t i = 0; i < one.pairs.size(); ++i) {
    EXPECT_EQ(one.pairs[i].source, four.pairs[i].source);
    EXPECT_EQ(one.pairs[i].target, four.pairs[i].target);
    EXPECT_EQ(one.pairs[i].best()->fine.target_from_source.Matrix(),
              four.pairs[i].best()->fine.target_from_source.Matrix());
  }
  EXPECT_EQ(Reasons(one), Reasons(four));
}

/// What is registered beside stations that come in this order.
RegisteredPairs RegisterEarly(const std::vector<Station>& stations, const PairSpec& spec,
                              const SurveyOptions& options, const ExecutionContext& context,
                              const std::vector<std::size_t>& order) {
  const ArtifactStore store;
  const PairUnits units(stations, options, context, store);
  EarlyPairs early(units, spec);
  WorkQueue queue(context);
  for (const std::size_t s : order) {
    queue.Add({.rank = 1}, [&early, &queue, s] { early.Join(s, &queue); });
  }
  queue.Run();
  return early.Take();
}

std::set<std::pair<int, int>> PairsOf(const RegisteredPairs& registered) {
  std::set<std::pair<int, int>> pairs;
  for (const auto& [stations, pair] : registered) pairs.insert(stations);
  return pairs;
}

using StationPairs = std::set<std::pair<int, int>>;

TEST(EarlyPairs, AreTheOnesThatAreTriedInAnyCase) {
  Yards yards(3, 1);
  for (std::size_t s = 0; s < 4; ++s) yards.stations[s].content_fingerprint = std::to_string(s);
  const ExecutionContext context(2);
  const auto pairs = [&](const PairSpec& spec, const SurveyOptions& options,
                         const std::vector<std::size_t>& order) {
    return PairsOf(RegisterEarly(yards.stations, spec, options, context, order));
  };
  PairSpec spec;
  spec.exclude = {{"S1", "S2"}};
  EXPECT_EQ(pairs(spec, {}, {2, 0, 3, 1}), (StationPairs{{2, 0}, {3, 0}, {2, 1}, {3, 1}, {3, 2}}));
  EXPECT_EQ(pairs(spec, {}, {3, 0}), (StationPairs{{3, 0}})) << "the others are not there";
  EXPECT_EQ(pairs(spec, Growing(), {0, 1, 2, 3}), StationPairs());
  spec.include = {{"S4", "S1"}};
  EXPECT_EQ(pairs(spec, Growing(), {0, 1, 2, 3}), (StationPairs{{3, 0}}));

  yards.stations[2].content_fingerprint = yards.stations[0].content_fingerprint;
  const StationPairs without_copy{{1, 0}, {3, 0}, {3, 1}};  // the later station is refused
  EXPECT_EQ(pairs({}, {}, {0, 2, 1, 3}), without_copy);
  EXPECT_EQ(pairs({}, {}, {2, 0, 1, 3}), without_copy);
}

TEST(EarlyPairs, AreNotRegisteredAgainAndChangeNothing) {
  Yards yards(3, 1);
  for (std::size_t s = 0; s < 4; ++s) yards.stations[s].content_fingerprint = std::to_string(s);
  const ExecutionContext context(2);
  const PairDiscovery plain = Discover(yards.stations, {}, {}, context);
  RegisteredPairs early = RegisterEarly(yards.stations, {}, {}, context, {1, 3, 0});
  ASSERT_EQ(early.size(), 3U);
  early.at({3, 0}).further_fault = "told apart by this";
  const ArtifactStore store;
  const PairDiscovery found =
      DiscoverPairs(PairUnits(yards.stations, {}, context, store), {}, std::move(early));
  ASSERT_EQ(found.pairs.size(), plain.pairs.size());
  EXPECT_EQ(found.full, plain.full);
  for (std::size_t i = 0; i < plain.pairs.size(); ++i) {
    const Pair& ours = found.pairs[i];
    const Pair& expected = plain.pairs[i];
    const bool marked = ours.source == 3 && ours.target == 0;
    EXPECT_EQ(ours.further_fault.empty(), !marked);
    EXPECT_EQ(ours.source, expected.source);
    EXPECT_EQ(ours.target, expected.target);
    ASSERT_EQ(ours.candidates.size(), expected.candidates.size());
    for (std::size_t c = 0; c < ours.candidates.size(); ++c) {
      EXPECT_EQ(ours.candidates[c].fine.target_from_source.Matrix(),
                expected.candidates[c].fine.target_from_source.Matrix());
    }
  }
}

TEST(PairDiscovery, ExcludedPairsAreSkippedAndIncludedOnesTried) {
  const Yards yards(3, 1);
  PairSpec spec;
  spec.exclude = {{"S1", "S2"}};
  spec.include = {{"S4", "S1"}};
  const PairDiscovery found = Discover(yards.stations, spec, Growing(), ExecutionContext(1));
  ASSERT_FALSE(found.skipped.empty());
  EXPECT_EQ(found.skipped[0].reason, "excluded");
  EXPECT_EQ(found.skipped[0].source, 1);
  EXPECT_EQ(found.skipped[0].target, 0);
  EXPECT_TRUE(std::any_of(found.pairs.begin(), found.pairs.end(), [](const Pair& pair) {
    return pair.source == 3 && pair.target == 0 && !pair.accepted();
  }));
}

TEST(PairDiscovery, PriorsKeepStationsApartAndRejectWhatContradictsThem) {
  Yards yards(3, 0);
  for (std::size_t s = 0; s < 3; ++s) {
    yards.stations[s].spec.prior = StationPrior{yards.yard_from_station[s], 0.2, 2.0};
  }
  EXPECT_EQ(Discover(yards.stations, {}, {}, ExecutionContext(1)).components, 1);

  StationPrior& third = *yards.stations[2].spec.prior;
  third.survey_from_station.translation += Eigen::Vector3d(5.0, 0.0, 0.0);
  const PairDiscovery wrong = Discover(yards.stations, {}, {}, ExecutionContext(1));
  EXPECT_EQ(wrong.components, 2);
  for (const Pair& pair : wrong.pairs) {
    EXPECT_EQ(ToString(pair.reason()), pair.source == 2 ? "contradicts_prior" : "");
  }

  third.survey_from_station.translation += Eigen::Vector3d(50.0, 0.0, 0.0);
  const PairDiscovery far = Discover(yards.stations, {}, {}, ExecutionContext(1));
  EXPECT_EQ(Reasons(far), (std::vector<std::string>{"prior_too_far", "prior_too_far"}));
}

TEST(PairDiscovery, EveryPairReachesTheRecords) {
  Yards yards(2, 2);
  yards.stations[3].fault = "cannot be read";
  SurveyProject project;
  project.pairs.exclude = {{"S1", "S3"}};
  const PairDiscovery found = Discover(yards.stations, project.pairs, {}, ExecutionContext(1));
  const Network network = BuildNetwork(yards.stations, found.pairs, {}, ExecutionContext(1));
  const RunRecord run = SummarizeRun(project, yards.stations, found, network, {}, {}, {}, {});
  ASSERT_EQ(run.links.size(), 6U);
  for (std::size_t k = 3; k < 6; ++k) {
    EXPECT_EQ(run.links[k].source, "S4");
    EXPECT_EQ(run.links[k].reason, "unusable_station");
  }
  EXPECT_EQ(run.links[2].status, LinkStatus::kSkipped);
  EXPECT_EQ(run.links[2].source, "S3");
  EXPECT_EQ(run.links[2].reason, "excluded");
}

}  // namespace
}  // namespace backsight
