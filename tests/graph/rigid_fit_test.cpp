#include "graph/rigid_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

TEST(FitRigid, EqualsUmeyama) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto matches = MakeMatches(seed, {.inliers = 3 + static_cast<int>(seed), .noise_m = 0.5});
    const auto n = static_cast<Eigen::Index>(matches.c.size());
    Eigen::Matrix3Xd source(3, n);
    Eigen::Matrix3Xd target(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      source.col(i) = matches.c.source[static_cast<std::size_t>(i)];
      target.col(i) = matches.c.target[static_cast<std::size_t>(i)];
    }
    const Eigen::Matrix4d expected = Eigen::umeyama(source, target, false);
    const auto fit = FitRigid(matches.c, {});
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT((fit->Matrix() - expected).norm(), 1e-9) << seed;
  }
}

TEST(FitRigid, IntegerWeightsAreRepetitions) {
  const auto matches = MakeMatches(1, {.inliers = 12, .noise_m = 0.3});
  std::vector<double> weights;
  Correspondences repeated;
  for (std::uint32_t a = 0; a < 12; ++a) {
    weights.push_back(a % 4);
    for (std::uint32_t k = 0; k < a % 4; ++k) {
      repeated.Add(matches.c.source[a], matches.c.target[a], a, a);
    }
  }
  const auto weighted = FitRigid(matches.c, weights);
  const auto expected = FitRigid(repeated, {});
  ASSERT_TRUE(weighted && expected);
  EXPECT_TRANSFORM_NEAR(*weighted, *expected, 1e-12, 1e-10);
  for (double& w : weights) w *= 1e-6;
  EXPECT_TRANSFORM_NEAR(*FitRigid(matches.c, weights), *expected, 1e-12, 1e-10);
}

TEST(FitRigid, IsTheMinimum) {
  const auto matches = MakeMatches(2, {.inliers = 20, .noise_m = 0.3});
  const auto cost = [&](const RigidTransform& t) {
    double sum = 0.0;
    for (std::size_t a = 0; a < matches.c.size(); ++a) {
      sum += (t * matches.c.source[a] - matches.c.target[a]).squaredNorm();
    }
    return sum;
  };
  const auto fit = FitRigid(matches.c, {});
  ASSERT_TRUE(fit.has_value());
  Random random(2);
  for (int k = 0; k < 100; ++k) {
    EXPECT_GT(cost(Retract(*fit, RandomTwist(random, 1e-4, 1e-3))), cost(*fit));
  }
}

TEST(FitRigid, RefusesWhatDeterminesNoMotion) {
  Random random(3);
  const RigidTransform truth = RandomTransform(random, 5.0);
  Correspondences collinear;
  Correspondences coincident;
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Eigen::Vector3d q(0.1 + 0.3 * i, 2.0 - 0.7 * i, 0.5 * i);
    collinear.Add(q, truth * q, i, i);
    coincident.Add({1, 2, 3}, {4, 5, 6}, i, i);
  }
  EXPECT_FALSE(FitRigid(collinear, {}).has_value());
  EXPECT_FALSE(FitRigid(coincident, {}).has_value());
  EXPECT_FALSE(FitRigid({}, {}).has_value());
  const auto matches = MakeMatches(3, {.inliers = 5});
  EXPECT_FALSE(FitRigid(matches.c, std::vector<double>{1, 1, 0, 0, 0}).has_value());
  EXPECT_FALSE(FitRigid(matches.c, std::vector<double>(5, 0.0)).has_value());
  EXPECT_TRUE(FitRigid(matches.c, std::vector<double>{1, 1, 1, 0, 0}).has_value());
}

TEST(FitRigid, NeverMirrors) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    auto matches = MakeMatches(seed, {.inliers = 10, .noise_m = 0.1});
    const bool planar = seed % 2 == 0;
    for (auto& q : matches.c.source) q.z() = planar ? 0.0 : -q.z();
    const auto fit = FitRigid(matches.c, {});
    ASSERT_TRUE(fit.has_value());
    EXPECT_TRUE(fit->IsValid()) << seed;
  }
}

TEST(RowsWithin, IsExclusiveAndInOrder) {
  Correspondences c;
  for (std::uint32_t i = 0; i < 5; ++i) c.Add({0, 0, 0}, {1.0 * i, 0, 0}, i, i);
  EXPECT_EQ(RowsWithin(c, {}, 2.0), (std::vector<std::uint32_t>{0, 1}));
  const RigidTransform shift{Eigen::Matrix3d::Identity(), Eigen::Vector3d(3, 0, 0)};
  EXPECT_EQ(RowsWithin(c, shift, 1.5), (std::vector<std::uint32_t>{2, 3, 4}));
}

}  // namespace
}  // namespace backsight
