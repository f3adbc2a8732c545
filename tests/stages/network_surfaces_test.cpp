#include <gtest/gtest.h>

#include <numbers>

#include "stages/leaf_grid.h"
#include "stages/normal_orientation.h"
#include "stages/normals.h"
#include "tests/stages/plate_campaign.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

using Status = NetworkRefinementResult::Status;

/// What an instrument sees of pipes of 0.5 m that run through the hall in all directions.
std::vector<Eigen::Vector3d> SeePipes(Random& random, const Eigen::Vector3d& instrument) {
  Random layout(99);  // the same for all stations
  std::vector<Eigen::Vector3d> points;
  for (int pipe = 0; pipe < 10; ++pipe) {
    const Eigen::Matrix3d axes = layout.Rotation();
    const Eigen::Vector3d middle = RandomPoint(layout, 7.0);
    for (int i = 0; i < 1200; ++i) {
      const double angle = random.Uniform(0.0, 2.0 * std::numbers::pi);
      const Eigen::Vector3d normal = std::cos(angle) * axes.col(0) + std::sin(angle) * axes.col(1);
      const Eigen::Vector3d point =
          middle + 0.25 * normal + random.Uniform(-2.0, 2.0) * axes.col(2);
      if (normal.dot(instrument - point) > 0.0) points.push_back(point);
    }
  }
  return points;
}

/// A campaign of plates and pipes, and the normals that its surfaces need.
struct PipeCampaign {
  PipeCampaign(std::uint64_t seed, int stations)
      : plates(MakePlateCampaign(seed, {.stations = stations, .things = SeePipes})) {
    const ExecutionContext context(1);
    for (const StationModel& model : plates.models) {
      std::vector<Eigen::Vector3f> positions;
      positions.reserve(model.leaves.size());
      for (const Eigen::Vector3d& mean : model.leaves.means()) {
        positions.push_back(mean.cast<float>());
      }
      const double radius_m = 2.0 * model.resolution_m();
      normals.push_back(EstimateNormals(LeafGrid(positions, radius_m), radius_m, context));
      OrientNormals(model, context, &normals.back());
    }
    for (const auto& own : normals) plates.input.normals.push_back(&own);
  }

  PlateCampaign plates;
  std::vector<std::vector<Eigen::Vector3f>> normals;
};

TEST(RefineNetworkOnSurfaces, TheSameBitsForAnyNumberOfThreads) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    PipeCampaign campaign(seed, 5);
    const NetworkRefinementResult one = Refine(campaign.plates, {}, 1);
    ASSERT_EQ(one.status, Status::kRefined);
    ASSERT_GT(one.rounds.back().surface_matches, 1000);
    for (const int threads : {2, 5}) {
      const NetworkRefinementResult many = Refine(campaign.plates, {}, threads);
      for (std::size_t s = 0; s < 5; ++s) {
        EXPECT_EQ(one.survey_from_station[s].Matrix(), many.survey_from_station[s].Matrix());
      }
      EXPECT_EQ(one.covariance, many.covariance);
      EXPECT_EQ(one.surface_factor, many.surface_factor);
      EXPECT_EQ(one.variance_factor, many.variance_factor);
      EXPECT_EQ(one.weakest.direction, many.weakest.direction);
      ASSERT_EQ(one.rounds.size(), many.rounds.size());
      for (std::size_t r = 0; r < one.rounds.size(); ++r) {
        EXPECT_EQ(one.rounds[r].surface_matches, many.rounds[r].surface_matches);
        EXPECT_EQ(one.rounds[r].cost_after, many.rounds[r].cost_after);
      }
    }
  }
}

TEST(RefineNetworkOnSurfaces, TakePartOnlyWhereAsked) {
  PipeCampaign campaign(3, 4);
  const NetworkRefinementResult with = Refine(campaign.plates);
  const NetworkRefinementResult without = Refine(campaign.plates, {.surfaces = false});
  ASSERT_EQ(with.status, Status::kRefined);
  ASSERT_EQ(without.status, Status::kRefined);
  EXPECT_GT(with.rounds.back().surface_matches, 1000);
  for (const RefinementRound& round : without.rounds) EXPECT_EQ(round.surface_matches, 0);
  EXPECT_EQ(with.rounds.front().surface_matches, 0) << "planes first";
  for (std::size_t s = 1; s < 4; ++s) {
    EXPECT_NE(with.survey_from_station[s].Matrix(), without.survey_from_station[s].Matrix());
    EXPECT_TRANSFORM_NEAR(with.survey_from_station[s], campaign.plates.truth[s], 1e-4, 1e-3) << s;
  }
}

}  // namespace
}  // namespace backsight
