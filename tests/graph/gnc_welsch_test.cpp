#include "graph/gnc_welsch.h"

#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

using Status = GncWelschResult::Status;
constexpr double kResolution = 0.1;

/// A start as edge reliability leaves it: some l off at the points.
RigidTransform CoarseStart(Random& random, const RigidTransform& truth) {
  const RigidTransform off{ExpSo3(0.01 * random.Rotation().col(0)),
                           2.0 * kResolution * random.Rotation().col(0)};
  return truth * off;
}

TEST(EstimateGncWelsch, Survives60PercentOutliers) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto matches =
        MakeMatches(seed, {.inliers = 80, .outliers = 120, .noise_m = 0.02, .extent_m = 10.0});
    Random random(seed);
    const auto result =
        EstimateGncWelsch(matches.c, CoarseStart(random, matches.target_from_source), {});
    EXPECT_EQ(result.status, Status::kConverged) << seed;
    const Vector6d error = LocalDifference(
        {result.target_from_source.rotation.transpose() * matches.target_from_source.rotation,
         Eigen::Vector3d::Zero()},
        {});
    EXPECT_LT(error.norm(), 0.003) << seed;
    double inlier_weight = 0.0;
    double all_weight = 0.0;
    for (const std::uint32_t row : matches.inlier_rows) inlier_weight += result.weights[row];
    for (const double w : result.weights) {
      EXPECT_GE(w, 0.0);
      EXPECT_LE(w, 1.0);
      all_weight += w;
    }
    EXPECT_GT(inlier_weight, 40.0);
    EXPECT_LT(all_weight - inlier_weight, 1.0) << "outliers carry no weight";
    EXPECT_NEAR(result.residual_sd_m, 0.02, 0.006);
  }
}

TEST(EstimateGncWelsch, DoesNotDependOnFrames) {
  Random random(1);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto matches =
        MakeMatches(seed, {.inliers = 60, .outliers = 60, .noise_m = 0.03, .extent_m = 10.0});
    const RigidTransform start = CoarseStart(random, matches.target_from_source);
    const RigidTransform a = RandomTransform(random, 100.0);
    const RigidTransform b = RandomTransform(random, 100.0);
    const auto before = EstimateGncWelsch(matches.c, start, {});
    const auto after = EstimateGncWelsch(Moved(matches.c, b, a), a * start * b.Inverse(), {});
    const RigidTransform expected = a * before.target_from_source * b.Inverse();
    EXPECT_TRANSFORM_NEAR(after.target_from_source, expected, 1e-9, 1e-7);
    EXPECT_NEAR(after.residual_sd_m, before.residual_sd_m, 1e-9);
    // Perturbing T by xi perturbs a T b by Adjoint(a) xi.
    const Matrix6d adjoint = Adjoint(a.Inverse());
    const Matrix6d moved = adjoint.transpose() * before.information * adjoint;
    EXPECT_LT((after.information - moved).norm(), 1e-6 * moved.norm());
  }
}

TEST(EstimateGncWelsch, DoesNotDependOnUnits) {
  Random random(2);
  const auto matches =
      MakeMatches(2, {.inliers = 60, .outliers = 60, .noise_m = 0.03, .extent_m = 10.0});
  const RigidTransform start = CoarseStart(random, matches.target_from_source);
  const auto metres = EstimateGncWelsch(matches.c, start, {.resolution_m = kResolution});
  for (const double scale : {1000.0, 1e-3}) {
    Correspondences scaled = matches.c;
    for (auto& q : scaled.source) q *= scale;
    for (auto& p : scaled.target) p *= scale;
    const auto other = EstimateGncWelsch(scaled, {start.rotation, scale * start.translation},
                                         {.resolution_m = scale * kResolution});
    EXPECT_EQ(other.iterations, metres.iterations);
    EXPECT_NEAR(other.sigma_m, scale * metres.sigma_m, 1e-9 * scale);
    EXPECT_TRANSFORM_NEAR((RigidTransform{other.target_from_source.rotation,
                                          other.target_from_source.translation / scale}),
                          metres.target_from_source, 1e-9, 1e-8);
  }
}

TEST(EstimateGncWelsch, ExactDataExactly) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto matches = MakeMatches(seed, {.inliers = 30, .outliers = 10});
    Random random(seed);
    const auto result =
        EstimateGncWelsch(matches.c, CoarseStart(random, matches.target_from_source), {});
    EXPECT_EQ(result.status, Status::kConverged);
    EXPECT_TRANSFORM_NEAR(result.target_from_source, matches.target_from_source, 1e-8, 1e-6);
    EXPECT_TRUE(result.information.allFinite());
  }
}

TEST(EstimateGncWelsch, ScaleStaysWithinItsBounds) {
  for (const double noise : {0.0, 0.02, 0.035, 0.06, 0.09}) {
    const auto matches = MakeMatches(3, {.inliers = 300, .noise_m = noise});
    const auto result = EstimateGncWelsch(matches.c, matches.target_from_source, {});
    EXPECT_GE(result.sigma_m, 0.5 * kResolution - 1e-12);
    EXPECT_LE(result.sigma_m, 1.5 * kResolution + 1e-12);
    if (noise == 0.035) {
      EXPECT_NEAR(result.sigma_m, 2.0 * noise, 0.01);
    }
  }
}

TEST(EstimateGncWelsch, DegenerateInputReturnsTheStart) {
  Random random(4);
  const RigidTransform start = RandomTransform(random, 5.0);
  Correspondences collinear;
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Eigen::Vector3d q(1.0 * i, 0, 0);
    collinear.Add(q, start * q, i, i);
  }
  Correspondences far;  // no row anywhere near
  for (std::uint32_t i = 0; i < 10; ++i) far.Add({1, 2, 3}, {1e6, 1e6, 1e6}, i, i);
  for (const Correspondences& c :
       {Correspondences{}, MakeMatches(5, {.inliers = 2}).c, collinear, far}) {
    const auto result = EstimateGncWelsch(c, start, {});
    EXPECT_EQ(result.status, Status::kDegenerate);
    EXPECT_EQ(result.target_from_source.Matrix(), start.Matrix());
    EXPECT_EQ(result.weights.size(), c.size());
    EXPECT_TRUE(result.information.allFinite());
  }
}

TEST(EstimateGncWelsch, InformationMatchesTheScatterOfSolutions) {
  // Within and at the lower bound of the adaptive scale.
  for (const double noise : {0.01, 0.04}) {
    double nees = 0.0;
    constexpr int kSeeds = 150;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const auto matches = MakeMatches(1000 + seed, {.inliers = 150, .noise_m = noise});
      const auto result = EstimateGncWelsch(matches.c, matches.target_from_source, {});
      const Vector6d error = LocalDifference(result.target_from_source, matches.target_from_source);
      nees += error.dot(result.information * error) / (6.0 * kSeeds);
    }
    EXPECT_GT(nees, 0.7) << noise;
    EXPECT_LT(nees, 1.4) << noise;
  }
}

}  // namespace
}  // namespace backsight
