#include "pipeline/network_pipeline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/pipeline/hall_stations.h"

namespace backsight {
namespace {

constexpr double kShiftSigma = 0.01;  // m, of every link

/// Accepted by its key points; true but for `shift`.
Pair TruePair(const HallStations& hall, int source, int target,
              const Eigen::Vector3d& shift = {0, 0, 0}) {
  Pair pair = HallStations::MakePair(source, target);
  PairCandidate& candidate = pair.candidates.emplace_back();
  candidate.fine.status = FineResult::Status::kRefined;
  candidate.fine.target_from_source = hall.Truth(source, target);
  candidate.fine.target_from_source.translation += shift;
  constexpr double kTurnSigma = 1e-4;
  candidate.fine.information.diagonal()
      << Eigen::Vector3d::Constant(1.0 / (kTurnSigma * kTurnSigma)),
      Eigen::Vector3d::Constant(1.0 / (kShiftSigma * kShiftSigma));
  candidate.fine.planes = 100;
  candidate.coarse.target_from_source = candidate.fine.target_from_source;
  candidate.verification.verdict = Verdict::kAccepted;
  candidate.verification.reason = VerificationResult::Reason::kNone;
  candidate.verification.consensus = 40;
  candidate.verification.overlap = 0.5;
  candidate.verification.quality.value = 0.9;
  return pair;
}

TEST(BuildNetwork, MeasuresHowFarLinksLieFromTheNetworkInTheirSigmas) {
  const HallScene scene(7, {.boxes = 8});
  const std::vector<Eigen::Vector3d> places = {
      {-6.0, -3.0, 1.6}, {3.0, 2.0, 1.7}, {0.0, -2.0, 1.6}, {5.0, -3.0, 1.5}, {-4.0, 2.0, 1.6}};
  const HallStations hall(scene, places, 5);
  // A triangle, whose links share a misclosure of 3 sigma, and a link that nothing checks.
  const std::vector<Pair> pairs = {
      TruePair(hall, 1, 0, Eigen::Vector3d(0.0, 0.0, 3.0 * kShiftSigma)), TruePair(hall, 2, 1),
      TruePair(hall, 2, 0), TruePair(hall, 3, 2)};
  SurveyOptions options;
  options.network.floor_rotation_deg = options.network.floor_translation_m = 0.0;
  options.refinement.enabled = false;
  const Network network = BuildNetwork(hall.stations, pairs, options, ExecutionContext(1));
  EXPECT_EQ(network.component, (std::vector<int>{0, 0, 0, 0, -1}));
  ASSERT_EQ(network.candidates.size(), 4U);
  // Each of the triangle's takes a third: one sigma in one of six unknowns.
  const double expected = 1.0 / std::sqrt(6.0) / network.solution.sigma_factor;
  for (std::size_t l = 0; l < 3; ++l) {
    ASSERT_TRUE(network.candidates[l].residual_sigmas);
    EXPECT_NEAR(*network.candidates[l].residual_sigmas, expected, 0.02 * expected) << l;
  }
  EXPECT_NEAR(network.candidates[3].residual_sigmas.value(), 0.0, 1e-6);
}

TEST(BuildNetwork, MeasuresNoResidualBetweenComponents) {
  const HallScene scene(7, {.boxes = 8});
  const std::vector<Eigen::Vector3d> places = {
      {-6.0, -3.0, 1.6}, {3.0, 2.0, 1.7}, {0.0, -2.0, 1.6}, {5.0, -3.0, 1.5}};
  const HallStations hall(scene, places, 5);
  std::vector<Pair> pairs = {TruePair(hall, 1, 0), TruePair(hall, 3, 2), TruePair(hall, 2, 0)};
  pairs[2].candidates[0].verification.verdict = Verdict::kDoubtful;
  SurveyOptions options;
  options.refinement.enabled = false;
  const Network network = BuildNetwork(hall.stations, pairs, options, ExecutionContext(1));
  EXPECT_TRUE(network.candidates[0].residual_sigmas);
  EXPECT_TRUE(network.candidates[1].residual_sigmas);
  EXPECT_FALSE(network.candidates[2].used());
  EXPECT_FALSE(network.candidates[2].residual_sigmas);
}

}  // namespace
}  // namespace backsight
