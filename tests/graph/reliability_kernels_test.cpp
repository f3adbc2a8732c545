#include "graph/reliability_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "graph/edge_evaluator.h"
#include "graph/pair_columns.h"
#include "tests/support/instruction_sets.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

float ExpNegative(float y) {
  return 1.0F +
         y * (-1.0F + y * (0.5F + y * (-0.16666667F +
                                       y * (0.041666667F + y * (-0.0083333333F + y * 0.00130F)))));
}

/// One row after the other, every root taken; eight sums, b modulo 8.
float ReferenceReliability(const ColumnView& c, const CompatibilityRule& rule, std::size_t a) {
  const auto weight = [&](std::size_t b) {
    const float ux = c.qx[b] - c.qx[a], uy = c.qy[b] - c.qy[a], uz = c.qz[b] - c.qz[a];
    const float vx = c.px[b] - c.px[a], vy = c.py[b] - c.py[a], vz = c.pz[b] - c.pz[a];
    const float in_source = ux * ux + uy * uy + uz * uz;
    const float in_target = vx * vx + vy * vy + vz * vz;
    const float length = std::sqrt(in_source);
    const float x = std::abs(length - std::sqrt(in_target));
    const bool level = std::abs(uz - vz) < rule.height_m + rule.slope * length;
    const bool compatible = x < rule.limit_m && in_source > 0.0F && in_target > 0.0F && level;
    return compatible ? ExpNegative(x * x * rule.inverse_6l2) : 0.0F;
  };
  float lanes[8] = {};
  const std::size_t whole = c.rows - c.rows % 8;
  for (std::size_t b = 0; b < whole; ++b) lanes[b % 8] += weight(b);
  float sum = 0.0F;
  for (const float lane : lanes) sum += lane;
  for (std::size_t b = whole; b < c.rows; ++b) sum += weight(b);
  return sum;
}

SyntheticMatches Matches(std::uint64_t seed) {
  // Numbers of rows with every remainder, once beyond what is listed at a time, and clouds of
  // several sizes.
  const int rows = (seed == 16 ? 2100 : 300) + static_cast<int>(seed);
  constexpr double kExtents[] = {2.0, 40.0, 400.0};
  return MakeMatches(
      seed,
      {.inliers = 60, .outliers = rows - 60, .noise_m = 0.03, .extent_m = kExtents[seed % 3]});
}

/// Moves rows from `first` on far out, and together by fours, half a metre apart: lengths that
/// products of their coordinates hardly tell.
void Gather(std::size_t first, Correspondences* c) {
  Random random(first);
  for (std::size_t row = first; row < c->size(); ++row) {
    const std::size_t center = first + (row - first) / 4 * 4;
    if (row == center) {
      c->source[row] *= 10.0;
      c->target[row] *= 10.0;
      continue;
    }
    const Eigen::Vector3d step = random.Rotation().col(0);
    const double longer = random.Uniform(0.9, 1.1);
    c->source[row] = c->source[center] + 0.5 * step;
    c->target[row] = c->target[center] + 0.5 * longer * random.Rotation().col(0);
  }
}

TEST(ReliabilityKernels, SumsAreTheSameBitsWithEveryInstructionSet) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::uint64_t seed = 0; seed < 17; ++seed) {
    Correspondences c = Matches(seed).c;
    c.source[7] = c.source[8];  // a shared key point
    Gather(c.size() / 2, &c);
    const PairColumns columns(c);
    for (const CompatibilityRule& rule : {CompatibilityRule{0.2F, infinity, 0.0F, 1.0F / 0.06F},
                                          CompatibilityRule{0.02F, infinity, 0.0F, 1.0F / 0.0006F},
                                          CompatibilityRule{0.2F, 0.2F, 0.02F, 1.0F / 0.06F}}) {
      std::vector<float> expected;
      for (std::size_t a = 0; a < c.size(); ++a) {
        expected.push_back(ReferenceReliability(View(columns), rule, a));
      }
      ASSERT_GT(*std::max_element(expected.begin(), expected.end()), 1.0F);
      ForEachInstructionSet([&](const std::string& name) {
        std::vector<float> sums(c.size() - 3);
        SumReliabilities(View(columns), rule, 3, sums);
        EXPECT_TRUE(std::equal(sums.begin(), sums.end(), expected.begin() + 3)) << name;
        std::vector<float> all(c.size());
        SumAllReliabilities(View(columns), rule, all);
        EXPECT_EQ(all, expected) << name;
      });
    }
  }
}

TEST(ReliabilityKernels, FindsAllOfTheSameLengthAndHardlyMore) {
  for (std::uint64_t seed = 0; seed < 17; ++seed) {
    const Correspondences c = Matches(seed).c;
    const PairColumns columns(c);
    constexpr double kLimit = 0.2;
    for (std::size_t a = 0; a < c.size(); a += 7) {
      const auto x = [&](std::size_t b) {
        return std::abs((c.source[b] - c.source[a]).norm() - (c.target[b] - c.target[a]).norm());
      };
      ForEachInstructionSet([&](const std::string& name) {
        std::vector<std::uint32_t> found(c.size() + PairColumns::kPadding);
        found.resize(FindSameLength(View(columns), a, a, static_cast<float>(kLimit), Slack(columns),
                                    found.data()));
        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
        for (std::uint32_t b = static_cast<std::uint32_t>(a); b < c.size(); ++b) {
          const bool is_found = std::binary_search(found.begin(), found.end(), b);
          EXPECT_TRUE(is_found || x(b) >= kLimit) << name;
        }
        for (const std::uint32_t b : found) EXPECT_LT(x(b), 1.5 * kLimit) << name;
      });
    }
  }
}

TEST(ReliabilityKernels, FindsAllAlongAnEdgeUnlessTheyAreTooFew) {
  constexpr double kLimit = 0.2;
  for (std::uint64_t seed = 0; seed < 17; ++seed) {
    const SyntheticMatches matches = Matches(seed);
    const Correspondences& c = matches.c;
    const PairColumns columns(c);
    const std::uint32_t i = matches.inlier_rows[0];
    const std::uint32_t j = matches.inlier_rows[1];
    const Eigen::Vector3d in_source = (c.source[j] - c.source[i]).normalized();
    const Eigen::Vector3d in_target = (c.target[j] - c.target[i]).normalized();
    const Eigen::Vector3f q = in_source.cast<float>();
    const Eigen::Vector3f p = in_target.cast<float>();
    const EdgeAxes edge{i, q.x(), q.y(), q.z(), p.x(), p.y(), p.z()};
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t k = 0; k < c.size(); ++k) {
      const Eigen::Vector3d s = c.source[k] - c.source[i];
      const Eigen::Vector3d m = c.target[k] - c.target[i];
      if (std::abs(s.norm() - m.norm()) < kLimit &&
          std::abs(s.dot(in_source) - m.dot(in_target)) < kLimit) {
        wanted.push_back(k);
      }
    }
    ASSERT_GE(wanted.size(), 40U);
    ForEachInstructionSet([&](const std::string& name) {
      std::vector<std::uint32_t> found(c.size() + PairColumns::kPadding);
      const auto find = [&](std::size_t bar) {
        return FindAlongEdge(View(columns), edge, static_cast<float>(kLimit), Slack(columns), bar,
                             found.data());
      };
      const std::size_t all = find(0);
      EXPECT_TRUE(std::includes(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(all),
                                wanted.begin(), wanted.end()))
          << name;
      EXPECT_EQ(find(all - 1), all) << name;
      EXPECT_EQ(find(all), 0U) << name;
    });
  }
}

}  // namespace
}  // namespace backsight
