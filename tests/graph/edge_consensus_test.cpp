#include "graph/edge_consensus.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "graph/correspondence_graph.h"
#include "graph/edge_length.h"
#include "graph/rigid_fit.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.1;

std::vector<EdgeHypothesis> Find(const Correspondences& c, int threads = 1,
                                 EdgeReliabilityOptions options = {}) {
  return FindEdgeHypotheses(c, options, ExecutionContext(threads));
}

Correspondences Reliable(const Correspondences& c) {
  const auto nodes =
      SelectReliableNodes(c, {.resolution_m = kResolution, .keep = 800}, ExecutionContext(1));
  return c.Subset(nodes.rows);
}

TEST(AreOneLength, EqualsTheComparisonOfRoots) {
  Random random(1);
  const auto direction = [&] {
    return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
  };
  int alike = 0;
  for (int i = 0; i < 20000; ++i) {
    const double limit_m = random.Uniform(0.05, 0.5);
    const Eigen::Vector3d a = random.Uniform(0.0, i % 2 == 0 ? 2.0 : 60.0) * direction();
    const Eigen::Vector3d b = (a.norm() + random.Uniform(-1.2, 1.2) * limit_m) * direction();
    const bool expected =
        std::abs(a.norm() - b.norm()) < limit_m && a.norm() > limit_m && b.norm() > limit_m;
    EXPECT_EQ(AreOneLength(a, b, limit_m), expected) << a.norm() << " " << b.norm();
    alike += expected ? 1 : 0;
  }
  EXPECT_GT(alike, 10000);
  EXPECT_LT(alike, 19000);
}

TEST(FindEdgeHypotheses, RecoversTheMotionAmong97PercentOutliers) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const auto matches = MakeMatches(seed, {.inliers = 60, .outliers = 1940, .noise_m = 0.02});
    const auto hypotheses = Find(Reliable(matches.c));
    ASSERT_FALSE(hypotheses.empty()) << seed;
    EXPECT_GE(hypotheses[0].consensus, 50) << seed;
    EXPECT_LE(hypotheses[0].consensus, 64) << seed;
    // Two ends 2 l off over a typical edge of 15 m, at the points themselves within some l.
    const RigidTransform& found = hypotheses[0].target_from_source;
    EXPECT_LT(RotationAngle(found.rotation, matches.target_from_source.rotation), 0.03) << seed;
    for (const std::uint32_t row : matches.inlier_rows) {
      EXPECT_LT((found * matches.c.source[row] - matches.c.target[row]).norm(), 6 * kResolution);
    }
    const auto fit =
        FitRigid(matches.c.Subset(RowsWithin(matches.c, found, 3.0 * kResolution)), {});
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT(RotationAngle(fit->rotation, matches.target_from_source.rotation), 0.002) << seed;
  }
}

TEST(FindEdgeHypotheses, RecoversExactDataExactly) {
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    const auto matches = MakeMatches(seed, {.inliers = 60, .outliers = 1940});
    const auto hypotheses = Find(Reliable(matches.c));
    ASSERT_FALSE(hypotheses.empty());
    EXPECT_GE(hypotheses[0].consensus, 60);
    const auto rows = RowsWithin(matches.c, hypotheses[0].target_from_source, 3.0 * kResolution);
    const auto fit = FitRigid(matches.c.Subset(rows), {});
    ASSERT_TRUE(fit.has_value());
    EXPECT_TRANSFORM_NEAR(*fit, matches.target_from_source, 1e-10, 1e-8);
  }
}

TEST(FindEdgeHypotheses, OppositeAxesAreAligned) {
  // Half turns about each axis make the edge's two directions opposite, exactly or nearly.
  const auto matches = MakeMatches(30, {.inliers = 40});
  for (const Eigen::Vector3d& phi :
       {Eigen::Vector3d(M_PI, 0, 0), Eigen::Vector3d(0, M_PI, 0), Eigen::Vector3d(0, 0, M_PI),
        Eigen::Vector3d(0, 0, M_PI - 1e-9)}) {
    const RigidTransform truth{ExpSo3(phi), Eigen::Vector3d(1.0, 2.0, 3.0)};
    Correspondences c;
    for (std::uint32_t i = 0; i < 40; ++i) {
      Eigen::Vector3d q = matches.c.source[i];
      // All edges along x or nearly so at first: the axis that two of the half turns reverse.
      if (i < 20) q = {2.0 * i, i < 2 ? 0.0 : q.y(), i < 2 ? 0.0 : q.z()};
      c.Add(q, truth * q, i, i);
    }
    const auto hypotheses = Find(c);
    ASSERT_FALSE(hypotheses.empty());
    EXPECT_EQ(hypotheses[0].consensus, 40);
    EXPECT_TRUE(hypotheses[0].target_from_source.IsValid());
    EXPECT_EQ(RowsWithin(c, hypotheses[0].target_from_source, 2.0 * kResolution).size(), 40U);
  }
}

TEST(FindEdgeHypotheses, MirroredPointsAreNoConsensus) {
  for (std::uint64_t seed = 40; seed < 45; ++seed) {
    auto matches = MakeMatches(seed, {.inliers = 60});
    for (auto& q : matches.c.source) q.z() = -q.z();  // all distances are kept
    for (const EdgeHypothesis& hypothesis : Find(matches.c)) {
      EXPECT_NEAR(hypothesis.target_from_source.rotation.determinant(), 1.0, 1e-9);
      EXPECT_LT(hypothesis.consensus, 15);
    }
  }
}

TEST(FindEdgeHypotheses, ConsensusCountsDistinctSourcePoints) {
  const auto matches = MakeMatches(50, {.inliers = 30});
  Correspondences fans;
  for (std::uint32_t i = 0; i < 30; ++i) {
    for (std::uint32_t k = 0; k < 5; ++k) {
      const Eigen::Vector3d aside(0.01 * k, 0.0, 0.0);
      fans.Add(matches.c.source[i], matches.c.target[i] + aside, i, 5 * i + k);
    }
  }
  const auto hypotheses = Find(fans);
  ASSERT_FALSE(hypotheses.empty());
  EXPECT_EQ(hypotheses[0].consensus, 30);
}

TEST(FindEdgeHypotheses, BestFirstAndDistinct) {
  // Two motions at once: 50 rows follow one, 35 the other.
  auto first = MakeMatches(60, {.inliers = 50, .noise_m = 0.01});
  const auto second = MakeMatches(61, {.inliers = 35, .noise_m = 0.01});
  for (std::uint32_t i = 0; i < 35; ++i) {
    first.c.Add(second.c.source[i], second.c.target[i], 100 + i, 100 + i);
  }
  const auto hypotheses = Find(first.c);
  ASSERT_GE(hypotheses.size(), 2U);
  EXPECT_NEAR(hypotheses[0].consensus, 50, 3);
  EXPECT_NEAR(hypotheses[1].consensus, 35, 3);
  EXPECT_TRANSFORM_NEAR(hypotheses[0].target_from_source, first.target_from_source, 0.03, 1.0);
  EXPECT_TRANSFORM_NEAR(hypotheses[1].target_from_source, second.target_from_source, 0.03, 1.0);
  for (std::size_t i = 1; i < hypotheses.size(); ++i) {
    EXPECT_LE(hypotheses[i].consensus, hypotheses[i - 1].consensus);
  }
  EXPECT_EQ(Find(first.c, 1, {.hypotheses = 1}).size(), 1U);
}

TEST(FindEdgeHypotheses, DoesNotDependOnThreads) {
  const auto matches = MakeMatches(70, {.inliers = 50, .outliers = 500, .noise_m = 0.02});
  const auto one = Find(matches.c, 1);
  const auto four = Find(matches.c, 4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].consensus, four[i].consensus);
    EXPECT_EQ(one[i].target_from_source.Matrix(), four[i].target_from_source.Matrix());
  }
}

TEST(FindEdgeHypotheses, MorePartnersNeverLoseConsensus) {
  const auto matches = MakeMatches(80, {.inliers = 25, .outliers = 400, .noise_m = 0.04});
  const auto one = Find(matches.c, 1, {.edges_per_node = 1});
  const auto eight = Find(matches.c, 1, {.edges_per_node = 8});
  ASSERT_FALSE(one.empty());
  ASSERT_FALSE(eight.empty());
  EXPECT_GE(eight[0].consensus, one[0].consensus);
}

TEST(FindEdgeHypotheses, DegenerateInputGivesNothing) {
  EXPECT_TRUE(Find({}).empty());
  Correspondences c;
  c.Add({0, 0, 0}, {1, 0, 0}, 0, 0);
  EXPECT_TRUE(Find(c).empty());
  c.Add({5, 0, 0}, {6, 0, 0}, 1, 1);
  EXPECT_TRUE(Find(c).empty());
  Correspondences coincident;
  for (std::uint32_t i = 0; i < 50; ++i) coincident.Add({1, 2, 3}, {4, 5, 6}, i, i);
  EXPECT_TRUE(Find(coincident).empty());
}

}  // namespace
}  // namespace backsight
