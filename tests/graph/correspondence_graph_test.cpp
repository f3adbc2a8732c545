#include "graph/correspondence_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.1;

/// Straight from the definition, in double precision.
std::vector<double> ReferenceReliability(const Correspondences& c, double l) {
  std::vector<double> d(c.size(), 0.0);
  for (std::size_t a = 0; a < c.size(); ++a) {
    for (std::size_t b = 0; b < c.size(); ++b) {
      const double in_source = (c.source[a] - c.source[b]).norm();
      const double in_target = (c.target[a] - c.target[b]).norm();
      if (in_source == 0.0 || in_target == 0.0) continue;
      const double x = std::abs(in_source - in_target);
      if (x < 2.0 * l) d[a] += std::exp(-x * x / (6.0 * l * l));
    }
  }
  return d;
}

ReliableNodes Select(const Correspondences& c, double l, int keep, int threads = 1) {
  const ExecutionContext context(threads);
  return SelectReliableNodes(c, {.resolution_m = l, .keep = keep}, context);
}

/// A pair whose lengths differ by almost exactly 2 l may count in one precision and not in the
/// other; one such flip is worth exp(-4/6) = 0.51.
void ExpectCloseUpToFlips(double actual, double expected, int flips_allowed) {
  const double difference = std::abs(actual - expected);
  const double flips = std::round(difference / 0.5134);
  EXPECT_LE(flips, flips_allowed);
  EXPECT_LT(std::abs(difference - 0.5134 * flips), 1e-4 * (1.0 + expected) + 1e-3 * flips);
}

TEST(SelectReliableNodes, EqualsTheDefinition) {
  for (const double l : {0.05, 0.1, 0.3}) {
    const auto matches =
        MakeMatches(1, {.inliers = 80, .outliers = 1200, .noise_m = 0.2 * l, .extent_m = 200 * l});
    const auto expected = ReferenceReliability(matches.c, l);
    const auto result = Select(matches.c, l, 200);
    ASSERT_EQ(result.reliability.size(), expected.size());
    int flipped = 0;
    for (std::size_t a = 0; a < expected.size(); ++a) {
      ExpectCloseUpToFlips(static_cast<double>(result.reliability[a]), expected[a], 1);
      const double difference = std::abs(static_cast<double>(result.reliability[a]) - expected[a]);
      if (difference > 1e-4 * expected[a]) ++flipped;
    }
    EXPECT_LT(flipped, 60) << "a threshold flip must be rare";
  }
}

TEST(SelectReliableNodes, KeepsTheMostReliable) {
  const auto matches = MakeMatches(2, {.inliers = 80, .outliers = 1200, .noise_m = 0.02});
  const auto expected = ReferenceReliability(matches.c, kResolution);
  const auto result = Select(matches.c, kResolution, 150);
  ASSERT_EQ(result.rows.size(), 150U);
  std::vector<double> sorted = expected;
  std::sort(sorted.rbegin(), sorted.rend());
  for (const std::uint32_t row : result.rows) EXPECT_GT(expected[row], sorted[149] - 0.6);
  for (std::size_t i = 1; i < result.rows.size(); ++i) {
    const float before = result.reliability[result.rows[i - 1]];
    const float here = result.reliability[result.rows[i]];
    EXPECT_TRUE(before > here || (before == here && result.rows[i - 1] < result.rows[i]));
  }
  // What the step is for: every true row vouches for every other.
  for (const std::uint32_t row : matches.inlier_rows) {
    EXPECT_NE(std::find(result.rows.begin(), result.rows.end(), row), result.rows.end());
  }
}

TEST(SelectReliableNodes, TiesGoByRow) {
  Correspondences c;
  for (std::uint32_t i = 0; i < 9; ++i) {
    // Lengths in the target are far longer: no row is compatible with another.
    c.Add({1.0 * i, 0, 0}, {100.0 * i, 0, 0}, i, i);
  }
  const auto result = Select(c, kResolution, 4);
  EXPECT_EQ(result.rows, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  for (const float d : result.reliability) EXPECT_EQ(d, 0.0F);
}

TEST(SelectReliableNodes, SharedKeyPointsDoNotVouchForEachOther) {
  Correspondences c;
  const Eigen::Vector3d q(3.0, 1.0, 2.0);
  for (std::uint32_t i = 0; i < 5; ++i) c.Add(q, {0.01 * i, 7.0, 1.0}, 0, i);  // same source
  for (std::uint32_t i = 0; i < 5; ++i) c.Add({30.0 + 0.01 * i, 9, 9}, {99, 0, 0}, 9 + i, 9);
  for (const float d : Select(c, kResolution, 10).reliability) EXPECT_EQ(d, 0.0F);
}

TEST(SelectReliableNodes, DoesNotDependOnThreads) {
  const auto matches = MakeMatches(3, {.inliers = 50, .outliers = 1511, .noise_m = 0.03});
  const auto one = Select(matches.c, kResolution, 500, 1);
  const auto four = Select(matches.c, kResolution, 500, 4);
  EXPECT_EQ(one.rows, four.rows);
  EXPECT_EQ(one.reliability, four.reliability);
}

TEST(SelectReliableNodes, DoesNotDependOnFrames) {
  const auto matches = MakeMatches(4, {.inliers = 60, .outliers = 600, .noise_m = 0.02});
  Random random(4);
  const auto moved = Moved(matches.c, RandomTransform(random, 1e6), RandomTransform(random, 1e6));
  const auto before = Select(matches.c, kResolution, 100);
  const auto after = Select(moved, kResolution, 100);
  for (std::size_t a = 0; a < matches.c.size(); ++a) {
    ExpectCloseUpToFlips(static_cast<double>(after.reliability[a]),
                         static_cast<double>(before.reliability[a]), 1);
  }
}

TEST(SelectReliableNodes, AcceptsFewRows) {
  EXPECT_TRUE(Select({}, kResolution, 10).rows.empty());
  Correspondences c;
  c.Add({1, 2, 3}, {4, 5, 6}, 0, 0);
  EXPECT_EQ(Select(c, kResolution, 10).rows.size(), 1U);
  EXPECT_EQ(Select(c, kResolution, 10).reliability[0], 0.0F);
}

}  // namespace
}  // namespace backsight
