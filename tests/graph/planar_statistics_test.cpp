#include "graph/planar_statistics.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numeric>

#include "graph/planar_adjustment.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

/// Joint covariance with the first station fixed.
Eigen::MatrixXd Covariance(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows() - 6;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n + 6, n + 6);
  covariance.bottomRightCorner(n, n) =
      information.bottomRightCorner(n, n).ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  return covariance;
}

std::vector<std::uint64_t> OnePlaneABlock(std::size_t planes) {
  std::vector<std::uint64_t> blocks(planes);
  std::iota(blocks.begin(), blocks.end(), std::uint64_t{0});
  return blocks;
}

TEST(Agreement, ExcessIsChiSquaredAtTheTruth) {
  double sum = 0.0;
  double freedom = 0.0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const SyntheticPlanes scene = MakePlanes(seed, {.stations = 4, .noise_m = 0.004});
    for (const WeightedPlane& plane : scene.planes) {
      const PlaneAgreement agreement = Agreement(plane, scene.world_from_station);
      sum += agreement.excess_m2 / (0.004 * 0.004);
      freedom += agreement.freedom;
      EXPECT_EQ(agreement.freedom, 3 * (static_cast<int>(plane.observations.size()) - 1));
      // A fitted plane takes three degrees of freedom out of 40 points.
      EXPECT_NEAR(std::sqrt(agreement.own_thickness_m2), 0.004 * std::sqrt(37.0 / 40.0), 0.001);
    }
  }
  // Some 3500 degrees of freedom: a standard error of 0.024.
  EXPECT_NEAR(sum / freedom, 1.0, 0.08);
}

TEST(EstimateVarianceFactor, IsOneForHonestWeightsAndFindsTheirScale) {
  for (const double scale : {1.0, 4.0}) {
    double sum = 0.0;
    constexpr int kSeeds = 10;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SyntheticPlanes scene = MakePlanes(seed, {.stations = 4, .planes = 200, .noise_m = 0.004});
      for (WeightedPlane& plane : scene.planes) plane.weight *= scale;
      const auto result = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {});
      sum +=
          EstimateVarianceFactor({scene.planes, {}, OnePlaneABlock(scene.planes.size())},
                                 result.poses, Covariance(result.information), ExecutionContext(1))
              .factor;
    }
    EXPECT_NEAR(sum / kSeeds / scale, 1.0, 0.1) << scale;
  }
}

TEST(EstimateVarianceFactor, SeesErrorsThatNeighboursShare) {
  // Every plane is there four times with the same errors: its information is claimed four times.
  double single = 0.0;
  double blocks = 0.0;
  constexpr int kSeeds = 10;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SyntheticPlanes scene = MakePlanes(seed, {.stations = 3, .planes = 150, .noise_m = 0.004});
    std::vector<WeightedPlane> planes;
    std::vector<std::uint64_t> block;
    for (std::size_t k = 0; k < scene.planes.size(); ++k) {
      for (int copy = 0; copy < 4; ++copy) {
        planes.push_back(scene.planes[k]);
        block.push_back(k);
      }
    }
    const auto result = AdjustPlanes(planes, {}, scene.world_from_station, 0, {});
    const Eigen::MatrixXd covariance = Covariance(result.information);
    const ExecutionContext context(1);
    single += EstimateVarianceFactor({planes, {}, OnePlaneABlock(planes.size())}, result.poses,
                                     covariance, context)
                  .factor;
    blocks += EstimateVarianceFactor({planes, {}, block}, result.poses, covariance, context).factor;
  }
  EXPECT_NEAR(single / kSeeds, 1.0, 0.15);
  EXPECT_NEAR(blocks / kSeeds, 4.0, 0.6);
}

TEST(EstimateVarianceFactor, ThreadsDoNotChangeABit) {
  const SyntheticPlanes scene = MakePlanes(1, {.stations = 5, .planes = 100, .noise_m = 0.004});
  const auto result = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {});
  const Eigen::MatrixXd covariance = Covariance(result.information);
  const auto blocks = OnePlaneABlock(scene.planes.size());
  const auto factor = [&](int threads) {
    return EstimateVarianceFactor({scene.planes, {}, blocks}, result.poses, covariance,
                                  ExecutionContext(threads))
        .factor;
  };
  EXPECT_EQ(factor(1), factor(4));
}

}  // namespace
}  // namespace backsight
