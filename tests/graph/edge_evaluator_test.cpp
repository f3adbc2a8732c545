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

/// The best motion about an edge with no bound and every row's interval of angles.
EdgeHypothesis Reference(const Correspondences& c, std::uint32_t i, std::uint32_t j) {
  const Eigen::Vector3d axis_q = (c.source[j] - c.source[i]).normalized();
  const Eigen::Vector3d axis = (c.target[j] - c.target[i]).normalized();
  const Eigen::Vector3d shift =
      0.5 * ((c.target[j] - c.target[i]) - (c.source[j] - c.source[i]).norm() * axis);
  const Eigen::Matrix3d align = Eigen::Quaterniond::FromTwoVectors(axis_q, axis).toRotationMatrix();
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  std::vector<AngleInterval> intervals;
  std::uint32_t ids = 0;
  for (std::uint32_t k = 0; k < c.size(); ++k) {
    ids = std::max(ids, c.source_id[k] + 1);
    const Eigen::Vector3d s = c.source[k] - c.source[i];
    const Eigen::Vector3d q = c.target[k] - c.target[i];
    if (!(std::abs(s.norm() - q.norm()) < kLimit) ||
        !(std::abs(s.dot(axis_q) - q.dot(axis)) < kLimit)) {
      continue;
    }
    const Eigen::Vector3d m = align * s + shift;
    const double radius_m = std::hypot(m.dot(u), m.dot(v));
    const double radius_q = std::hypot(q.dot(u), q.dot(v));
    const double along = q.dot(axis) - m.dot(axis);
    if ((radius_m - radius_q) * (radius_m - radius_q) + along * along > kLimit * kLimit) continue;
    const double product = 2.0 * radius_m * radius_q;
    const double kappa =
        product > 1e-12
            ? (radius_m * radius_m + radius_q * radius_q + along * along - kLimit * kLimit) /
                  product
            : -1.0;
    if (kappa <= -1.0) {
      intervals.push_back({0.0, 2.0 * std::numbers::pi, c.source_id[k]});
      continue;
    }
    const double half = std::acos(std::min(kappa, 1.0));
    const double center = std::atan2(q.dot(v), q.dot(u)) - std::atan2(m.dot(v), m.dot(u));
    intervals.push_back({center - half, center + half, c.source_id[k]});
  }
  const StabbingResult stabbed = IntervalStabber(ids).Stab(intervals);
  EdgeHypothesis best;
  best.consensus = stabbed.count;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(stabbed.angle, axis).toRotationMatrix();
  best.target_from_source = {turn * align, c.target[i] + turn * (shift - align * c.source[i])};
  return best;
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
    for (int trial = 0; trial < 400; ++trial) {
      const auto i = static_cast<std::uint32_t>(random.Index(c.size()));
      const auto j = static_cast<std::uint32_t>(random.Index(c.size()));
      const double in_source = (c.source[i] - c.source[j]).norm();
      const double in_target = (c.target[i] - c.target[j]).norm();
      if (std::min(in_source, in_target) < kLimit) continue;
      const EdgeHypothesis expected = Reference(c, i, j);
      for (const int bar : {0, 3, expected.consensus - 1, expected.consensus}) {
        if (bar < 0) continue;
        const auto found = evaluator.Evaluate(i, j, bar);
        if (!found || found->consensus <= bar) {
          EXPECT_LE(expected.consensus, bar);
          ++given_up;
          continue;
        }
        EXPECT_EQ(found->consensus, expected.consensus);
        EXPECT_EQ(found->target_from_source.Matrix(), expected.target_from_source.Matrix());
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(given_up, 1000);
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
      if (i != j) known.push_back(Reference(c, i, j));
    }
    std::sort(known.begin(), known.end(),
              [](const auto& a, const auto& b) { return a.consensus > b.consensus; });
    const HypothesisNearness nearness{c.source[0], 0.035, 0.6};
    for (int trial = 0; trial < 300; ++trial) {
      const auto [i, j] = random_edge();
      if (i == j || (c.source[i] - c.source[j]).norm() < kLimit) continue;
      const EdgeHypothesis expected = Reference(c, i, j);
      const auto found = evaluator.Evaluate(i, j, 3, {known, nearness});
      if (found) {
        EXPECT_EQ(found->consensus, expected.consensus);
        ++compared;
      } else if (expected.consensus > 3) {
        EXPECT_TRUE(std::any_of(known.begin(), known.end(), [&](const EdgeHypothesis& h) {
          return h.consensus >= expected.consensus &&
                 nearness.IsNear(h.target_from_source, expected.target_from_source);
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
