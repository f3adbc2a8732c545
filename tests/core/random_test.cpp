#include "core/random.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <set>
#include <vector>

namespace backsight {
namespace {

constexpr int kSamples = 200000;
// Five standard errors of a mean of kSamples values with standard deviation 1.
const double kFiveSigma = 5.0 / std::sqrt(static_cast<double>(kSamples));

TEST(Random, UniformHasItsMoments) {
  Random random(1);
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = random.Uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kSamples, 0.5, 0.29 * kFiveSigma);
  EXPECT_NEAR(squares / kSamples, 1.0 / 3.0, 0.30 * kFiveSigma);
}

TEST(Random, UniformKeepsItsRange) {
  Random random(2);
  double least = 1e9;
  double most = -1e9;
  for (int i = 0; i < kSamples; ++i) {
    const double x = random.Uniform(-3.0, 5.0);
    least = std::min(least, x);
    most = std::max(most, x);
  }
  EXPECT_GE(least, -3.0);
  EXPECT_LT(most, 5.0);
  EXPECT_LT(least, -2.99);
  EXPECT_GT(most, 4.99);
}

TEST(Random, NormalHasItsMoments) {
  Random random(3);
  double moments[5] = {};
  double correlation = 0.0;
  double before = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = random.Normal();
    ASSERT_TRUE(std::isfinite(x));
    for (int m = 1; m <= 4; ++m) moments[m] += std::pow(x, m) / kSamples;
    correlation += x * before / kSamples;
    before = x;
  }
  // Standard deviations of x^1..x^4: 1, sqrt 2, sqrt 15, sqrt 96.
  EXPECT_NEAR(moments[1], 0.0, kFiveSigma);
  EXPECT_NEAR(moments[2], 1.0, 1.42 * kFiveSigma);
  EXPECT_NEAR(moments[3], 0.0, 3.88 * kFiveSigma);
  EXPECT_NEAR(moments[4], 3.0, 9.80 * kFiveSigma);
  EXPECT_NEAR(correlation, 0.0, kFiveSigma);
}

TEST(Random, IndexCoversItsRangeEvenly) {
  Random random(4);
  std::vector<int> counts(7, 0);
  for (int i = 0; i < 70000; ++i) ++counts.at(random.Index(7));
  for (const int count : counts) EXPECT_NEAR(count, 10000, 5.0 * std::sqrt(10000.0));
}

TEST(Random, RotationsAreRotations) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Matrix3d r = random.Rotation();
    ASSERT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    ASSERT_NEAR(r.determinant(), 1.0, 1e-14);
  }
}

TEST(Random, RotationsAreUniform) {
  Random random(6);
  constexpr int kRotations = 50000;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double trace_squares = 0.0;
  for (int i = 0; i < kRotations; ++i) {
    const Eigen::Matrix3d r = random.Rotation();
    mean += r / kRotations;
    squares += r.cwiseProduct(r) / kRotations;
    trace_squares += r.trace() * r.trace() / kRotations;
  }
  // Under the Haar measure every entry has mean 0 and variance 1/3, and E[tr^2] = 1.
  const double five_sigma = 5.0 / std::sqrt(static_cast<double>(kRotations));
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.58 * five_sigma);
  EXPECT_LT((squares.array() - 1.0 / 3.0).abs().maxCoeff(), 0.3 * five_sigma);
  EXPECT_NEAR(trace_squares, 1.0, 1.5 * five_sigma);
}

TEST(Random, SameSeedSameSequence) {
  Random a(7);
  Random b(7);
  Random c(8);
  EXPECT_EQ(a.Normal(), b.Normal());
  EXPECT_EQ(a.Rotation(), b.Rotation());
  EXPECT_NE(a.Uniform(), c.Uniform());
}

TEST(DeriveSeed, DependsOnSeedAndName) {
  std::set<std::uint64_t> seeds;
  for (const std::uint64_t seed : {0U, 1U, 2U}) {
    for (const char* name : {"", "S1", "S2", "pair S1 S2", "pair S2 S1"}) {
      seeds.insert(DeriveSeed(seed, name));
      EXPECT_EQ(DeriveSeed(seed, name), DeriveSeed(seed, name));
    }
  }
  EXPECT_EQ(seeds.size(), 15U);
}

}  // namespace
}  // namespace backsight
