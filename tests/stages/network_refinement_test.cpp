#include "stages/network_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/stages/plate_campaign.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

using Status = NetworkRefinementResult::Status;
using Reason = NetworkRefinementResult::Reason;

double Nees(const PlateCampaign& campaign, const NetworkRefinementResult& result) {
  const auto rows = static_cast<Eigen::Index>(6 * (campaign.truth.size() - 1));
  Eigen::VectorXd error(rows);
  for (std::size_t s = 1; s < campaign.truth.size(); ++s) {
    error.segment<6>(static_cast<Eigen::Index>(6 * (s - 1))) =
        LocalDifference(result.survey_from_station[s], campaign.truth[s]);
  }
  return error.dot(result.covariance.bottomRightCorner(rows, rows).ldlt().solve(error)) /
         static_cast<double>(rows);
}

TEST(RefineNetwork, RecoversTenStationsFromExactPlanes) {
  PlateCampaign campaign = MakePlateCampaign(1, {.stations = 10, .points = 40, .noise_m = 0.0});
  const NetworkRefinementResult result = Refine(campaign);
  ASSERT_EQ(result.status, Status::kRefined) << static_cast<int>(result.reason);
  EXPECT_GT(result.planes, 300);
  // The first station's planes are parallel to its voxels, so all means are rounded alike.
  constexpr double kRounding = 0x1p-17 * 0.1 * 2.0;
  for (std::size_t s = 0; s < campaign.truth.size(); ++s) {
    EXPECT_TRANSFORM_NEAR(result.survey_from_station[s], campaign.truth[s], 1e-7, kRounding) << s;
  }
  for (const RefinementRound& round : result.rounds) EXPECT_LE(round.iterations, 10);
}

TEST(RefineNetwork, StatedUncertaintiesComeTrue) {
  double sum = 0.0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PlateCampaign campaign = MakePlateCampaign(seed, {});
    const NetworkRefinementResult result = Refine(campaign);
    ASSERT_EQ(result.status, Status::kRefined) << seed;
    sum += Nees(campaign, result);
    EXPECT_NEAR(result.sigma0_m, 0.002, 0.0002);
  }
  // 20 networks of 18 degrees of freedom: a standard error of 0.075.
  EXPECT_GT(sum / kSeeds, 0.8);
  EXPECT_LT(sum / kSeeds, 1.2);
}

TEST(RefineNetwork, HeldOutPlanesSeeTheImprovement) {
  PlateCampaign campaign = MakePlateCampaign(2, {});
  const NetworkRefinementResult result = Refine(campaign);
  ASSERT_EQ(result.held_out.size(), 6U) << "every pair of four stations";
  int planes = 0;
  for (const HeldOutPair& pair : result.held_out) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_LT(pair.rms_after, 0.001) << pair.a << " " << pair.b;
    EXPECT_LE(std::abs(pair.bias_after), pair.rms_after);
    EXPECT_GT(pair.rms_before, pair.rms_after);
    planes += pair.planes;
  }
  // A tenth of the planes; each is seen by some three stations, which make three pairs.
  EXPECT_GT(planes, result.planes / 10);
  EXPECT_LT(planes, result.planes);
}

TEST(RefineNetwork, CostFallsInEveryRoundAndTheCovarianceIsSound) {
  PlateCampaign campaign = MakePlateCampaign(3, {});
  const NetworkRefinementResult result = Refine(campaign);
  ASSERT_EQ(result.status, Status::kRefined);
  ASSERT_GE(result.rounds.size(), 3U);
  for (const RefinementRound& round : result.rounds) {
    EXPECT_LE(round.cost_after, (1.0 + 1e-12) * round.cost_before);
    EXPECT_GT(round.planes, 200);
    EXPECT_GE(round.observations, 2 * round.planes);
  }
  EXPECT_EQ(result.covariance.rows(), 24);
  EXPECT_EQ(result.covariance.topRows(6).norm(), 0.0) << "the datum has no error";
  EXPECT_LT((result.covariance - result.covariance.transpose()).norm(),
            1e-12 * result.covariance.norm());
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(result.covariance.bottomRightCorner(18, 18)).info(),
            Eigen::Success);
  EXPECT_GT(result.weakest.sigma_m, 0.0);
  EXPECT_LT(result.weakest.sigma_m, 0.002);
  EXPECT_GE(result.weakest.station, 1);
  EXPECT_NEAR(result.weakest.direction.norm(), 1.0, 1e-12);
}

TEST(RefineNetwork, FloorOfTheStationsIsInTheCovariance) {
  PlateCampaign campaign = MakePlateCampaign(4, {});
  const auto without = Refine(campaign, {.floor_rotation_deg = 0.0, .floor_translation_m = 0.0});
  const auto with = Refine(campaign, {.floor_rotation_deg = 0.0, .floor_translation_m = 0.003});
  const Eigen::MatrixXd added = with.covariance - without.covariance;
  for (Eigen::Index s = 1; s < 4; ++s) {
    // The station's own and the datum's.
    EXPECT_NEAR(added(6 * s + 3, 6 * s + 3), 2 * 9e-6, 1e-9);
    EXPECT_NEAR(added(6 * s, 6 * s), 0.0, 1e-12);
  }
  EXPECT_NEAR(added(9, 15), 9e-6, 1e-9) << "the datum's is common to all";
}

TEST(RefineNetwork, TooFewPlanesLeaveThePosesAlone) {
  PlateCampaign campaign = MakePlateCampaign(5, {.stations = 3, .plates = 1});
  const NetworkRefinementResult result = Refine(campaign);
  EXPECT_EQ(result.status, Status::kTooFewPlanes);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(result.survey_from_station[s].Matrix(),
              campaign.input.survey_from_station[s].Matrix());
  }
  ASSERT_EQ(result.covariance.rows(), 18);
  EXPECT_TRUE(result.covariance.allFinite());
  for (Eigen::Index s = 1; s < 3; ++s) {
    const Matrix6d block = result.covariance.block<6, 6>(6 * s, 6 * s);
    const Matrix6d& expected = campaign.input.covariance[static_cast<std::size_t>(s)];
    EXPECT_LT((block - expected).norm(), 1e-6 * expected.norm());
  }

  PlateCampaign empty = MakePlateCampaign(5, {.stations = 2});
  for (StationModel& model : empty.models) model.leaves = {};
  const NetworkRefinementResult nothing = Refine(empty);
  EXPECT_EQ(nothing.status, Status::kTooFewPlanes);
  EXPECT_TRUE(nothing.covariance.allFinite());
}

TEST(RefineNetwork, AShiftedStationIsNotDraggedAndSpoilsNoOther) {
  PlateCampaign campaign = MakePlateCampaign(6, {.stations = 5});
  // All links of station 4 are wrong alike: nothing but the planes contradicts.
  const Eigen::Vector3d shift(1.1, -0.9, 1.3);
  for (PoseGraphLink& link : campaign.input.links) {
    if (link.source != 4) continue;
    const auto& target = campaign.truth[static_cast<std::size_t>(link.target)];
    link.target_from_source.translation += target.rotation.transpose() * shift;
  }
  SolveGraph(&campaign);
  const NetworkRefinementResult result = Refine(campaign);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_TRANSFORM_NEAR(result.survey_from_station[s], campaign.truth[s], 1e-3, 0.003) << s;
  }
  EXPECT_TRANSFORM_NEAR(result.survey_from_station[4], campaign.input.survey_from_station[4], 0.01,
                        0.05);
}

TEST(RefineNetwork, AStationWithoutPlanesKeepsWhatItsLinksSay) {
  PlateCampaign campaign = MakePlateCampaign(7, {.stations = 4});
  campaign.models[3].leaves = {};
  const NetworkRefinementResult result = Refine(campaign);
  ASSERT_EQ(result.status, Status::kRefined) << static_cast<int>(result.reason);
  EXPECT_EQ(result.planes_of_station[3], 0);
  EXPECT_TRANSFORM_NEAR(result.survey_from_station[3], campaign.truth[3], 5e-4, 0.01);
  // Three links of 4 mm hold it: some 2.3 mm are left, far above what planes give the others.
  const Matrix6d covariance = result.covariance.block<6, 6>(18, 18);
  EXPECT_NEAR(std::sqrt(covariance(3, 3)), 0.0025, 0.0015);
  EXPECT_LT(std::sqrt(result.covariance(9, 9)), 0.0005);
}

TEST(RefineNetwork, LevelsHoldTheTiltWhereNoPlaneDoes) {
  PlateCampaign campaign = MakePlateCampaign(8, {.stations = 3, .tilt_rad = 0.0});
  campaign.models[2].leaves = {};
  const auto tilt_sigma = [&](double level_rad) {
    campaign.input.level_sigma_rad.assign(3, std::nullopt);
    if (level_rad > 0.0) campaign.input.level_sigma_rad = {level_rad, level_rad, level_rad};
    const NetworkRefinementResult result = Refine(campaign);
    EXPECT_EQ(result.status, Status::kRefined);
    return std::sqrt(result.covariance(12, 12));
  };
  EXPECT_GT(tilt_sigma(0.0), 1.5e-4);
  EXPECT_LT(tilt_sigma(1e-5), 3e-5);
}

TEST(RefineNetwork, OneAndFourThreadsGiveTheSameBits) {
  PlateCampaign campaign = MakePlateCampaign(9, {.stations = 5});
  const NetworkRefinementResult a = Refine(campaign, {}, 1);
  const NetworkRefinementResult b = Refine(campaign, {}, 4);
  for (std::size_t s = 0; s < 5; ++s) {
    EXPECT_EQ(a.survey_from_station[s].Matrix(), b.survey_from_station[s].Matrix());
  }
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.weakest.direction, b.weakest.direction);
  EXPECT_EQ(a.planes, b.planes);
  EXPECT_EQ(a.variance_factor, b.variance_factor);
}

TEST(RefineNetwork, AndersonOnlySavesIterations) {
  PlateCampaign campaign = MakePlateCampaign(10, {});
  const NetworkRefinementResult with = Refine(campaign);
  const NetworkRefinementResult without = Refine(campaign, {.anderson_window = 0});
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_TRANSFORM_NEAR(with.survey_from_station[s], without.survey_from_station[s], 5e-6, 5e-5);
  }
  for (const RefinementRound& round : without.rounds) {
    EXPECT_EQ(round.anderson_accepted, 0);
    EXPECT_FALSE(round.anderson_start);
  }
}

TEST(RefineNetwork, OneStationIsNoNetwork) {
  PlateCampaign campaign = MakePlateCampaign(11, {.stations = 1});
  const NetworkRefinementResult result = Refine(campaign);
  EXPECT_EQ(result.status, Status::kTooFewPlanes);
  EXPECT_EQ(result.covariance, Eigen::MatrixXd::Zero(6, 6));
}

}  // namespace
}  // namespace backsight
