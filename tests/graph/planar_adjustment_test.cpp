#include "graph/planar_adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Status = PlanarAdjustmentResult::Status;
using Normals = SyntheticPlaneOptions::Normals;
constexpr double kTwoDegrees = 0.0349;

PlanarAdjustmentOptions Strict() {
  return {
      .relative_decrease = 0.0, .smallest_rotation_rad = 1e-12, .smallest_translation_m = 1e-11};
}

TEST(AdjustPlanes, RecoversExactBoxes) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const int stations = 2 + static_cast<int>(seed % 4);
    const auto scene = MakePlanes(
        seed, {.stations = stations, .planes = 60, .normals = Normals::kBox, .seen_by_all = true});
    Random random(seed);
    const auto start = Disturbed(random, scene.world_from_station, 0, kTwoDegrees, 0.1);
    const auto result = AdjustPlanes(scene.planes, {}, start, 0, {});
    EXPECT_EQ(result.status, Status::kConverged) << seed;
    EXPECT_LT(result.iterations, 15) << seed;
    EXPECT_LT(result.final_cost, 1e-6 * result.start_cost);
    for (std::size_t s = 0; s < start.size(); ++s) {
      EXPECT_TRANSFORM_NEAR(result.poses[s], scene.world_from_station[s], 1e-7, 1e-6) << seed;
    }
  }
}

TEST(AdjustPlanes, CostNeverRises) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto scene = MakePlanes(seed, {.stations = 3, .planes = 25, .noise_m = 0.02});
    Random random(seed);
    const auto start = Disturbed(random, scene.world_from_station, 0, 0.3, 1.0);
    double before = PlanarCost(scene.planes, {}, start);
    for (int iterations = 1; iterations < 12; ++iterations) {
      const auto result = AdjustPlanes(scene.planes, {}, start, 0, {.max_iterations = iterations});
      EXPECT_LE(result.iterations, iterations);
      EXPECT_LE(result.final_cost, before) << seed << " " << iterations;
      EXPECT_NEAR(result.final_cost, PlanarCost(scene.planes, {}, result.poses),
                  1e-9 * result.final_cost);
      before = result.final_cost;
    }
  }
}

TEST(AdjustPlanes, FixedStationStays) {
  const auto scene = MakePlanes(1, {.stations = 4, .planes = 60, .noise_m = 0.005});
  Random random(1);
  for (const int fixed : {0, 2, 3}) {
    const auto start = Disturbed(random, scene.world_from_station, fixed, kTwoDegrees, 0.1);
    const auto result = AdjustPlanes(scene.planes, {}, start, fixed, {});
    const auto f = static_cast<std::size_t>(fixed);
    EXPECT_LT((result.poses[f].Matrix() - start[f].Matrix()).norm(), 1e-14);
    for (std::size_t s = 0; s < start.size(); ++s) {
      EXPECT_TRANSFORM_NEAR(result.poses[s], scene.world_from_station[s], 0.003, 0.02);
    }
  }
}

TEST(AdjustPlanes, AndersonReachesTheSameMinimum) {
  int accepted = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto scene = MakePlanes(seed, {.stations = 3, .planes = 60, .noise_m = 0.005});
    Random random(seed);
    const auto start = Disturbed(random, scene.world_from_station, 0, kTwoDegrees, 0.1);
    for (const double damping : {1e-4, 10.0}) {
      PlanarAdjustmentOptions options = Strict();
      options.start_damping = damping;
      const auto with = AdjustPlanes(scene.planes, {}, start, 0, options);
      options.anderson_window = 0;
      const auto without = AdjustPlanes(scene.planes, {}, start, 0, options);
      EXPECT_EQ(without.anderson_accepted, 0);
      accepted += with.anderson_accepted;
      EXPECT_NEAR(with.final_cost, without.final_cost, 1e-9 * without.final_cost);
      for (std::size_t s = 0; s < start.size(); ++s) {
        EXPECT_TRANSFORM_NEAR(with.poses[s], without.poses[s], 1e-8, 1e-7);
      }
    }
  }
  EXPECT_GT(accepted, 0) << "the acceleration was never tried";
}

TEST(AdjustPlanes, NothingToDoLeavesThePoses) {
  Random random(2);
  const std::vector<RigidTransform> start = {RandomTransform(random, 5),
                                             RandomTransform(random, 5)};
  const auto no_planes = AdjustPlanes({}, {}, start, 0, {});
  EXPECT_EQ(no_planes.status, Status::kNothingToDo);
  EXPECT_EQ(no_planes.information.rows(), 12);
  EXPECT_TRUE(no_planes.information.allFinite());
  for (std::size_t s = 0; s < 2; ++s) EXPECT_EQ(no_planes.poses[s].Matrix(), start[s].Matrix());

  const auto scene = MakePlanes(2, {.stations = 1, .planes = 5, .noise_m = 0.01});
  const auto one_station = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {});
  EXPECT_EQ(one_station.status, Status::kNothingToDo);
  EXPECT_EQ(one_station.poses[0].Matrix(), scene.world_from_station[0].Matrix());
}

TEST(AdjustPlanes, ParallelPlanesGiveHeightAndTilt) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto scene = MakePlanes(
        seed, {.stations = 3, .planes = 40, .noise_m = 0.003, .normals = Normals::kParallel});
    Random random(seed);
    const auto start = Disturbed(random, scene.world_from_station, 0, 0.01, 0.05);
    const auto result = AdjustPlanes(scene.planes, {}, start, 0, {});
    EXPECT_TRUE(result.information.allFinite());
    EXPECT_LT(result.final_cost, 0.05 * result.start_cost);
    for (std::size_t s = 0; s < start.size(); ++s) {
      ASSERT_TRUE(result.poses[s].IsValid());
      const RigidTransform& truth = scene.world_from_station[s];
      EXPECT_NEAR(result.poses[s].translation.z(), truth.translation.z(), 0.02);
      EXPECT_LT((result.poses[s].rotation.row(2) - truth.rotation.row(2)).norm(), 0.004);
    }
  }
}

TEST(AdjustPlanes, ExactParallelPlanesMoveNothingAlongThem) {
  // Every normal is the z axis: the matrix has zeros where the gradient has rounding errors.
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto scene =
        MakePlanes(seed, {.stations = 3, .planes = 40, .normals = Normals::kParallel});
    auto start = scene.world_from_station;
    start[1].translation.z() += 0.05;
    start[2].translation.z() -= 0.08;
    const auto result = AdjustPlanes(scene.planes, {}, start, 0, {});
    for (std::size_t s = 0; s < start.size(); ++s) {
      EXPECT_TRANSFORM_NEAR(result.poses[s], scene.world_from_station[s], 0.03, 0.3) << seed;
    }
  }
}

TEST(AdjustPlanes, PriorsHoldWhatPlanesDoNotSee) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto scene = MakePlanes(
        seed, {.stations = 2, .planes = 40, .noise_m = 0.003, .normals = Normals::kParallel});
    Random random(seed);
    const auto start = Disturbed(random, scene.world_from_station, 0, 0.01, 0.05);
    // As a coarse registration leaves it: 1 mrad and 1 cm.
    PosePrior prior{.station = 1, .expected = start[1], .information = Matrix6d::Identity()};
    prior.information.topLeftCorner<3, 3>() *= 1e6;
    prior.information.bottomRightCorner<3, 3>() *= 1e4;
    const auto result = AdjustPlanes(scene.planes, std::vector{prior}, start, 0, {});
    const Vector6d moved = LocalDifference(result.poses[1], start[1]);
    EXPECT_LT(std::abs(moved[2]), 0.003) << "heading, seed " << seed;
    EXPECT_LT(moved.segment<2>(3).norm(), 0.05) << "seed " << seed;
    EXPECT_NEAR(result.poses[1].translation.z(), scene.world_from_station[1].translation.z(), 0.02);
  }
}

TEST(AdjustPlanes, InformationMatchesTheScatterOfSolutions) {
  constexpr int kSeeds = 40;
  constexpr int kStations = 4;
  double nees = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto scene =
        MakePlanes(100 + seed, {.stations = kStations, .planes = 60, .noise_m = 0.003});
    const auto result = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {});
    EXPECT_EQ(result.status, Status::kConverged);
    Eigen::VectorXd error(6 * (kStations - 1));
    for (int s = 1; s < kStations; ++s) {
      const auto i = static_cast<std::size_t>(s);
      error.segment<6>(6 * (s - 1)) = LocalDifference(result.poses[i], scene.world_from_station[i]);
    }
    const Eigen::MatrixXd information =
        result.information.bottomRightCorner(6 * (kStations - 1), 6 * (kStations - 1));
    nees += error.dot(information * error) / (kSeeds * 6.0 * (kStations - 1));
  }
  EXPECT_GT(nees, 0.8);
  EXPECT_LT(nees, 1.2);
}

}  // namespace
}  // namespace backsight
