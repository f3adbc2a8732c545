#include <gtest/gtest.h>

#include <limits>

#include "graph/plane_segmentation.h"
#include "stages/held_out_planes.h"
#include "tests/stages/plate_campaign.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

using Status = NetworkRefinementResult::Status;
using Reason = NetworkRefinementResult::Reason;

/// The poses are those handed in, to the bit; so are their covariances, as far as links give them.
void ExpectUntouched(const PlateCampaign& campaign, const NetworkRefinementResult& result) {
  const std::size_t stations = campaign.truth.size();
  ASSERT_EQ(result.survey_from_station.size(), stations);
  ASSERT_EQ(result.covariance.rows(), static_cast<Eigen::Index>(6 * stations));
  EXPECT_TRUE(result.covariance.allFinite());
  for (std::size_t s = 0; s < stations; ++s) {
    EXPECT_EQ(result.survey_from_station[s].Matrix(),
              campaign.input.survey_from_station[s].Matrix())
        << "station " << s;
    const auto row = static_cast<Eigen::Index>(6 * s);
    const Matrix6d block = result.covariance.block<6, 6>(row, row);
    EXPECT_LE((block - campaign.input.covariance[s]).norm(),
              1e-6 * campaign.input.covariance[s].norm())
        << "station " << s;
  }
}

/// All links of the last station turn it about a corner of the hall, the only part of it that it
/// sees: its planes are off by centimetres, its instrument by decimetres.
PlateCampaign MakeTurnedAboutACorner(std::uint64_t seed, double angle) {
  const Eigen::Vector3d corner(9.0, 9.0, 9.0);
  PlateCampaign campaign =
      MakePlateCampaign(seed, {.plates = 10, .seen = [&](int station, const Eigen::Vector3d& p) {
                                 return station != 3 || (p - corner).norm() < 7.0;
                               }});
  const Eigen::Matrix3d turn = ExpSo3({0.0, 0.0, angle});
  const RigidTransform about_corner{turn, corner - turn * corner};
  for (PoseGraphLink& link : campaign.input.links) {
    if (link.source != 3) continue;
    const RigidTransform& target = campaign.truth[static_cast<std::size_t>(link.target)];
    link.target_from_source = target.Inverse() * about_corner * target * link.target_from_source;
  }
  SolveGraph(&campaign);
  return campaign;
}

TEST(RefineNetworkRefuses, AStationThatMovesFartherThanItsStartCanBeWrong) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    PlateCampaign campaign = MakeTurnedAboutACorner(seed, seed % 2 == 0 ? 0.03 : -0.03);
    const NetworkRefinementResult result = Refine(campaign);
    EXPECT_EQ(result.status, Status::kKeptPoseGraph);
    EXPECT_EQ(result.reason, Reason::kStationMovedTooFar) << "seed " << seed;
    EXPECT_EQ(result.station, 3) << "seed " << seed;
    ExpectUntouched(campaign, result);

    // The same planes say the same; a start that may be that wrong gives way to them.
    for (Matrix6d& covariance : campaign.input.covariance) covariance *= 1e6;
    const NetworkRefinementResult unsure = Refine(campaign);
    EXPECT_EQ(unsure.status, Status::kRefined) << "seed " << seed;
    EXPECT_TRANSFORM_NEAR(unsure.survey_from_station[3], campaign.truth[3], 5e-4, 0.005) << seed;
  }
}

TEST(RefineNetworkRefuses, WhatMakesHeldOutPlanesWorse) {
  // Cells as wide as the plates' pitch: a plate lies in one cell, held out or not.
  NetworkRefinementOptions options;
  options.root_edge = 20.0;
  const Eigen::Vector3d shift(0.01, 0.01, -0.01);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const bool held_out_too : {false, true}) {
      PlateCampaign campaign = MakePlateCampaign(
          seed,
          {.link_error = 0.0, .measured = [&](int station, const Eigen::Vector3d& p) {
             const bool held_out = IsHeldOut(PlaneCell(p, 2.0, 0), options.held_out_share);
             return Eigen::Vector3d(station == 3 && (held_out_too || !held_out) ? p + shift : p);
           }});
      const NetworkRefinementResult result = Refine(campaign, options);
      if (held_out_too) {
        EXPECT_EQ(result.status, Status::kRefined) << "seed " << seed;
        continue;
      }
      EXPECT_EQ(result.status, Status::kKeptPoseGraph);
      EXPECT_EQ(result.reason, Reason::kHeldOutPlanesWorse) << "seed " << seed;
      ExpectUntouched(campaign, result);
    }
  }
}

TEST(RefineNetworkRefuses, WhatNothingDetermines) {
  for (const bool linked : {false, true}) {
    PlateCampaign campaign = MakePlateCampaign(3, {});
    // Its links, if any, hold nothing.
    campaign.models[3].leaves = {};
    if (!linked) {
      std::erase_if(campaign.input.links,
                    [](const PoseGraphLink& link) { return link.source == 3; });
    }
    for (PoseGraphLink& link : campaign.input.links) {
      if (link.source == 3) link.information.setZero();
    }
    const NetworkRefinementResult result = Refine(campaign);
    EXPECT_EQ(result.status, Status::kKeptPoseGraph);
    EXPECT_EQ(result.reason, Reason::kNotFinite);
    ExpectUntouched(campaign, result);
  }
}

TEST(RefineNetworkRefuses, APoseThatIsNotFinite) {
  PlateCampaign campaign = MakePlateCampaign(4, {});
  campaign.models[3].leaves = {};
  campaign.input.survey_from_station[3].translation.x() = std::numeric_limits<double>::quiet_NaN();
  const NetworkRefinementResult result = Refine(campaign);
  EXPECT_EQ(result.status, Status::kKeptPoseGraph);
  EXPECT_EQ(result.reason, Reason::kNotFinite);
  EXPECT_TRUE(result.covariance.allFinite());
}

TEST(RefineNetworkRefuses, TooFewPlanes) {
  for (std::uint64_t seed = 5; seed < 8; ++seed) {
    PlateCampaign campaign = MakePlateCampaign(seed, {.stations = 3});
    const NetworkRefinementResult result = Refine(campaign, {.min_planes = 10'000});
    EXPECT_EQ(result.status, Status::kTooFewPlanes);
    EXPECT_EQ(result.reason, Reason::kNone);
    ExpectUntouched(campaign, result);
  }
}

TEST(RefineNetwork, DoesNotRefuseAStartThatIsExact) {
  // Nothing but rounding errors is left to compare, of the cost as of held-out planes.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    PlateCampaign campaign =
        MakePlateCampaign(seed, {.points = 30, .noise_m = 0.0, .link_error = 0.0});
    campaign.input.survey_from_station = campaign.truth;
    const NetworkRefinementResult result = Refine(campaign);
    EXPECT_EQ(result.status, Status::kRefined) << seed << " " << static_cast<int>(result.reason);
  }
}

}  // namespace
}  // namespace backsight
