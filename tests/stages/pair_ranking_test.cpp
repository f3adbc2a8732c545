#include "stages/pair_ranking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/random.h"
#include "stages/features.h"
#include "stages/overlap_prediction.h"
#include "stages/station_priors.h"
#include "stages/station_signature.h"
#include "tests/support/feature_scene.h"

namespace backsight {
namespace {

/// Two looks at each of three yards: of one yard the voxels fall anew on a turned lattice.
struct Yards {
  std::vector<StationModel> models;
  std::vector<StationFeatures> features;

  explicit Yards(const ExecutionContext& context) {
    for (std::uint64_t yard = 0; yard < 3; ++yard) {
      const StationModel model = MakeYardStation(20 + yard, 1.0);
      std::vector<Eigen::Vector3d> turned;
      const Eigen::Matrix3d turn = ExpSo3({0.0, 0.0, 0.7});
      for (const Eigen::Vector3d& mean : model.leaves.means()) turned.push_back(turn * mean);
      models.push_back(model);
      models.push_back(MakeStation(turned, model.resolution_m()));
    }
    for (StationModel& model : models) {
      model.range_image = RangeImage(Eigen::Vector3d::Zero(), 1.0);
      for (const Eigen::Vector3d& mean : model.leaves.means()) model.range_image.Add(mean);
      features.push_back(ComputeFeatures(model, {}, context));
    }
  }
};

std::vector<PairProspect> AllPairs(int stations) {
  std::vector<PairProspect> candidates;
  for (int t = 0; t < stations; ++t) {
    for (int s = t + 1; s < stations; ++s) {
      PairProspect pair;
      pair.source = s, pair.target = t;
      candidates.push_back(pair);
    }
  }
  return candidates;
}

std::vector<RankedStation> Ranked(const Yards& yards) {
  std::vector<RankedStation> stations(yards.models.size());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    stations[s].model = &yards.models[s];
    stations[s].features = &yards.features[s];
    stations[s].range_m = 10.0;
  }
  return stations;
}

/// The same, with priors that place stations 1 and 4 together.
std::vector<RankedStation> RankedWithPriors(const Yards& yards) {
  std::vector<RankedStation> stations = Ranked(yards);
  stations[1].prior = StationPrior{};
  stations[4].prior = StationPrior{};
  return stations;
}

TEST(PairRanking, LooksAtTheSamePlaceComeFirst) {
  const ExecutionContext context(1);
  const Yards yards(context);
  std::vector<PairProspect> candidates = AllPairs(6);
  RankPairs(Ranked(yards), {}, context, &candidates);
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const PairProspect& a, const PairProspect& b) { return a.similarity > b.similarity; });
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(candidates[i].source / 2, candidates[i].target / 2);
}

TEST(PairRanking, PairsMatchedLaterRankAsIfMatchedAtOnce) {
  const ExecutionContext context(1);
  const Yards yards(context);
  const std::vector<RankedStation> stations = RankedWithPriors(yards);
  std::vector<PairProspect> at_once = AllPairs(6);
  RankPairs(stations, {}, context, &at_once);

  std::vector<PairProspect> later = AllPairs(6);
  RankPairs(stations, {.prematch_per_station = 1}, context, &later);
  std::vector<std::size_t> unmatched;
  for (std::size_t i = 0; i < later.size(); ++i) {
    EXPECT_FALSE(at_once[i].unmatched);
    if (!later[i].unmatched) continue;
    unmatched.push_back(i);
    EXPECT_LT(later[i].similarity, at_once[i].similarity) << "behind all that were matched";
  }
  ASSERT_GT(unmatched.size(), 3U);
  MatchPairs(stations, {}, context, unmatched, &later);
  for (std::size_t i = 0; i < later.size(); ++i) {
    EXPECT_EQ(later[i].similarity, at_once[i].similarity);
    EXPECT_FALSE(later[i].unmatched);
  }
}

TEST(PairRanking, DoesNotDependOnTheNumberOfThreads) {
  const Yards yards(ExecutionContext(1));
  std::vector<PairProspect> one = AllPairs(6);
  std::vector<PairProspect> four = one;
  RankPairs(Ranked(yards), {}, ExecutionContext(1), &one);
  RankPairs(Ranked(yards), {}, ExecutionContext(4), &four);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].similarity, four[i].similarity);
}

TEST(PairRanking, StationsThatPriorsPlaceTogetherComeFirst) {
  const ExecutionContext context(1);
  const Yards yards(context);
  const std::vector<RankedStation> stations = RankedWithPriors(yards);
  std::vector<PairProspect> candidates = AllPairs(6);
  RankPairs(stations, {}, context, &candidates);
  const auto best = std::max_element(
      candidates.begin(), candidates.end(),
      [](const PairProspect& a, const PairProspect& b) { return a.similarity < b.similarity; });
  EXPECT_EQ(best->target, 1);
  EXPECT_EQ(best->source, 4);
}

TEST(PairRanking, AStationThatCannotBeUsedIsPassedOver) {
  const ExecutionContext context(1);
  const Yards yards(context);
  std::vector<RankedStation> stations = Ranked(yards);
  stations[5] = RankedStation{};
  std::vector<PairProspect> candidates = AllPairs(5);
  RankPairs(stations, {}, context, &candidates);
  EXPECT_GT(candidates[0].similarity, candidates[1].similarity);
}

TEST(StationSignature, EqualStationsHaveEqualSignaturesOfLengthOne) {
  const ExecutionContext context(1);
  const Yards yards(context);
  std::vector<const StationFeatures*> features;
  for (const StationFeatures& f : yards.features) features.push_back(&f);
  features.push_back(&yards.features[0]);
  const StationFeatures none;
  features.push_back(&none);
  const auto signatures = ComputeSignatures(features, {}, context);
  EXPECT_EQ(signatures[0], signatures[6]);
  EXPECT_NEAR(signatures[0].norm(), 1.0F, 1e-5F);
  EXPECT_TRUE(signatures[7].isZero(0.0F));
}

TEST(OverlapPrediction, FollowsTheMotion) {
  const StationModel yard = MakeYardStation(3, 1.0);
  const CoarseOccupancy occupancy(yard);
  EXPECT_DOUBLE_EQ(PredictOverlap(occupancy, occupancy, {}), 1.0);
  RigidTransform motion;
  double before = 1.0;
  for (const double shift : {2.0, 4.0, 6.0, 8.0}) {  // the yard is 8.9 m wide
    motion.translation = {shift, 0.05, 0.0};
    const double overlap = PredictOverlap(occupancy, occupancy, motion);
    EXPECT_LT(overlap, before);
    before = overlap;
  }
  motion.translation = {1000.0, 0.0, 0.0};
  EXPECT_EQ(PredictOverlap(occupancy, occupancy, motion), 0.0);
}

TEST(StationPriors, AcceptWhatTheyAllowAndRejectWhatTheyRuleOut) {
  Random random(8);
  for (int trial = 0; trial < 50; ++trial) {
    StationPrior a{{random.Rotation(), {random.Uniform(-90.0, 90.0), 3.0, 1.0}}, 0.5, 2.0};
    StationPrior b{{random.Rotation(), {random.Uniform(-90.0, 90.0), -4.0, 0.0}}, 0.2, 1.0};
    const RigidTransform b_from_a = b.survey_from_station.Inverse() * a.survey_from_station;
    EXPECT_FALSE(ContradictsPriors(a, b, b_from_a, 0.1));
    const double limit_rad = 5.0 * std::hypot(2.0, 1.0) * std::numbers::pi / 180.0;
    RigidTransform turned = b_from_a;
    turned.rotation = turned.rotation * ExpSo3({0.0, 0.0, 0.98 * limit_rad});
    EXPECT_FALSE(ContradictsPriors(a, b, turned, 0.1));
    turned.rotation = b_from_a.rotation * ExpSo3({0.0, 0.0, 1.02 * limit_rad});
    EXPECT_TRUE(ContradictsPriors(a, b, turned, 0.1));
    const double lever_m = b_from_a.translation.norm() * std::numbers::pi / 180.0;
    const double limit_m = 5.0 * std::hypot(0.5, 0.2, lever_m) + 0.1;
    // Across the line of sight, so that the lever stays the same to first order.
    const Eigen::Vector3d across = b_from_a.translation.unitOrthogonal();
    RigidTransform shifted = b_from_a;
    shifted.translation += 0.9 * limit_m * across;
    EXPECT_FALSE(ContradictsPriors(a, b, shifted, 0.1));
    shifted.translation = b_from_a.translation + 1.5 * limit_m * across;
    EXPECT_TRUE(ContradictsPriors(a, b, shifted, 0.1));
  }
}

TEST(StationPriors, TooFarCountsTheRangeAndWhatThePriorsMayBeWrong) {
  StationPrior a;
  StationPrior b;
  a.sigma_m = b.sigma_m = 1.0;
  b.survey_from_station.translation = {1.5 * 40.0 + 5.0 * std::sqrt(2.0) - 0.01, 0.0, 0.0};
  EXPECT_FALSE(ArePriorsTooFar(a, b, 40.0));
  b.survey_from_station.translation.x() += 0.02;
  EXPECT_TRUE(ArePriorsTooFar(a, b, 40.0));
}

}  // namespace
}  // namespace backsight
