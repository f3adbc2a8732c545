#include "graph/edge_evaluator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/random.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

constexpr double kLimit = 0.2;

/// Whether a row lies alike in both clouds, seen from row i along the edge to row j.
bool LiesAlike(const Correspondences& c, std::uint32_t i, std::uint32_t j, std::uint32_t k) {
  const Eigen::Vector3d s = c.source[k] - c.source[i];
  const Eigen::Vector3d t = c.target[k] - c.target[i];
  return std::abs(s.norm() - t.norm()) < kLimit &&
         std::abs(s.dot((c.source[j] - c.source[i]).normalized()) -
                  t.dot((c.target[j] - c.target[i]).normalized())) < kLimit;
}

/// The motion that lays the edge on its target, both ends as far off, and turns by `angle`.
RigidTransform AboutEdge(const Correspondences& c, std::uint32_t i, std::uint32_t j, double angle) {
  const Eigen::Vector3d in_source = c.source[j] - c.source[i];
  const Eigen::Vector3d in_target = c.target[j] - c.target[i];
  const Eigen::Vector3d axis = in_target.normalized();
  const Eigen::Vector3d shift = 0.5 * (in_target - in_source.norm() * axis);
  const Eigen::Matrix3d align =
      Eigen::Quaterniond::FromTwoVectors(in_source, in_target).toRotationMatrix();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  return {turn * align, c.target[i] + turn * (shift - align * c.source[i])};
}

/// Distinct key points that the motion brings within the limit.
int Gathered(const Correspondences& c, std::uint32_t i, std::uint32_t j,
             const RigidTransform& motion) {
  constexpr double kRounding = 1e-9;
  std::set<std::uint32_t> ids;
  for (std::uint32_t k = 0; k < c.size(); ++k) {
    const double residual = (motion * c.source[k] - c.target[k]).norm();
    if (LiesAlike(c, i, j, k) && residual <= kLimit + kRounding) ids.insert(c.source_id[k]);
  }
  return static_cast<int>(ids.size());
}

/// The most that any rotation about the edge gathers. The count rises only at angles at which some
/// row comes within the limit, so those are enough.
int MostGathered(const Correspondences& c, std::uint32_t i, std::uint32_t j) {
  const RigidTransform start = AboutEdge(c, i, j, 0.0);
  const Eigen::Vector3d axis = (c.target[j] - c.target[i]).normalized();
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  int most = Gathered(c, i, j, start);
  for (std::uint32_t k = 0; k < c.size(); ++k) {
    if (!LiesAlike(c, i, j, k)) continue;
    const Eigen::Vector3d m = start * c.source[k] - c.target[i];
    const Eigen::Vector3d q = c.target[k] - c.target[i];
    const double along = (q - m).dot(axis);
    const double product = 2.0 * std::hypot(m.dot(u), m.dot(v)) * std::hypot(q.dot(u), q.dot(v));
    const double rest = std::pow(m.dot(u), 2) + std::pow(m.dot(v), 2) + std::pow(q.dot(u), 2) +
                        std::pow(q.dot(v), 2) + along * along - kLimit * kLimit;
    if (std::abs(rest) > product) continue;
    const double center = std::atan2(q.dot(v), q.dot(u)) - std::atan2(m.dot(v), m.dot(u));
    const double begin = center - std::acos(rest / product);
    most = std::max(most, Gathered(c, i, j, AboutEdge(c, i, j, begin)));
  }
  return most;
}

/// Rows that share source points, near the axis of many edges and far from it.
Correspondences Rows(std::uint64_t seed) {
  auto matches = MakeMatches(
      seed, {.inliers = 40, .outliers = 300, .noise_m = 0.05, .extent_m = seed % 2 ? 3.0 : 20.0});
  Random random(seed);
  for (int fan = 0; fan < 60; ++fan) {
    const std::size_t k = random.Index(matches.c.size());
    const Eigen::Vector3d aside(0.1 * random.Normal(), 0.1 * random.Normal(), 0.0);
    matches.c.Add(matches.c.source[k], matches.c.target[k] + aside, matches.c.source_id[k],
                  1000 + static_cast<std::uint32_t>(fan));
  }
  return matches.c;
}

TEST(EdgeEvaluator, EqualsTheSearchWithoutBounds) {
  int compared = 0;
  int given_up = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Correspondences c = Rows(seed);
    const PairColumns columns(c);
    EdgeEvaluator evaluator(c, columns, kLimit, std::nullopt);
    Random random(100 + seed);
    for (int trial = 0; trial < 100; ++trial) {
      const auto i = static_cast<std::uint32_t>(random.Index(c.size()));
      const auto j = static_cast<std::uint32_t>(random.Index(c.size()));
      const double in_source = (c.source[i] - c.source[j]).norm();
      const double in_target = (c.target[i] - c.target[j]).norm();
      if (std::min(in_source, in_target) < kLimit) continue;
      const int expected = MostGathered(c, i, j);
      for (const int bar : {0, 3, expected - 1, expected}) {
        if (bar < 0) continue;
        const auto found = evaluator.Evaluate(i, j, bar);
        if (!found || found->consensus <= bar) {
          EXPECT_LE(expected, bar);
          ++given_up;
          continue;
        }
        EXPECT_EQ(found->consensus, expected);
        EXPECT_EQ(Gathered(c, i, j, found->target_from_source), expected);
        EXPECT_LT((found->target_from_source.rotation * (c.source[j] - c.source[i]).normalized() -
                   (c.target[j] - c.target[i]).normalized())
                      .norm(),
                  1e-9);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(given_up, 300);
}

TEST(EdgeEvaluator, RulesOutOnlyWhatIsNearAKnownHypothesis) {
  int ruled_out = 0;
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const auto matches =
        MakeMatches(seed, {.inliers = 40, .outliers = 300, .noise_m = 0.03, .extent_m = 10.0});
    const Correspondences& c = matches.c;
    const PairColumns columns(c);
    EdgeEvaluator evaluator(c, columns, kLimit, std::nullopt);
    std::vector<std::uint32_t> true_rows;
    for (std::uint32_t row = 0; row < c.size(); ++row) {
      const Eigen::Vector3d moved = matches.target_from_source * c.source[row];
      if ((moved - c.target[row]).norm() < 0.15) true_rows.push_back(row);
    }
    Random random(200 + seed);
    const auto random_edge = [&] {
      return std::pair(true_rows[random.Index(true_rows.size())],
                       true_rows[random.Index(true_rows.size())]);
    };
    std::vector<EdgeHypothesis> known;
    while (known.size() < 10) {
      const auto [i, j] = random_edge();
      if (i == j || (c.source[i] - c.source[j]).norm() < kLimit) continue;
      if (const auto found = evaluator.Evaluate(i, j, 0)) known.push_back(*found);
    }
    std::sort(known.begin(), known.end(),
              [](const auto& a, const auto& b) { return a.consensus > b.consensus; });
    const HypothesisNearness nearness{c.source[0], 0.035, 0.6};
    for (int trial = 0; trial < 1500; ++trial) {
      const auto [i, j] = random_edge();
      if (i == j || (c.source[i] - c.source[j]).norm() < kLimit) continue;
      const auto expected = evaluator.Evaluate(i, j, 0);
      ASSERT_TRUE(expected);
      const auto found = evaluator.Evaluate(i, j, 3, {known, nearness});
      if (found) {
        EXPECT_EQ(found->consensus, expected->consensus);
        ++compared;
      } else if (expected->consensus > 3) {
        EXPECT_TRUE(std::any_of(known.begin(), known.end(), [&](const EdgeHypothesis& h) {
          return h.consensus >= expected->consensus &&
                 nearness.IsNear(h.target_from_source, expected->target_from_source);
        }));
        ++ruled_out;
      }
    }
  }
  EXPECT_GT(ruled_out, 20);
  EXPECT_GT(compared, 20);
}

TEST(EdgeEvaluator, UprightCountsDistinctPointsUnderTheBearing) {
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    auto matches = MakeMatches(seed, {.inliers = 30, .outliers = 100, .noise_m = 0.02});
    const RigidTransform level{
        Eigen::AngleAxisd(1.0 + static_cast<double>(seed), Eigen::Vector3d::UnitZ())
            .toRotationMatrix(),
        Eigen::Vector3d(3.0, -2.0, 0.5)};
    for (const std::uint32_t row : matches.inlier_rows) {
      matches.c.target[row] = level * matches.c.source[row];
    }
    const Correspondences& c = matches.c;
    const PairColumns columns(c);
    EdgeEvaluator evaluator(c, columns, kLimit, UprightConstraint{0.01});
    for (std::size_t k = 1; k < 20; ++k) {
      const auto found = evaluator.Evaluate(matches.inlier_rows[0], matches.inlier_rows[k], 3);
      if (!found || found->consensus <= 3) continue;  // too steep
      std::set<std::uint32_t> ids;
      for (std::uint32_t row = 0; row < c.size(); ++row) {
        const double residual = (found->target_from_source * c.source[row] - c.target[row]).norm();
        if (residual < kLimit) ids.insert(c.source_id[row]);
      }
      EXPECT_EQ(found->consensus, static_cast<int>(ids.size()));
      EXPECT_GE(found->consensus, 30);
    }
  }
}

}  // namespace
}  // namespace backsight
