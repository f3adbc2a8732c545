#include "graph/cycle_consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

std::vector<Matrix6d> Covariances(const std::vector<PoseGraphLink>& links) {
  std::vector<Matrix6d> covariances;
  for (const PoseGraphLink& link : links) covariances.push_back(link.information.inverse());
  return covariances;
}

/// A loop of `length` links, some of them backwards, and the way around it.
struct Loop {
  std::vector<PoseGraphLink> links;
  std::vector<int> order;
};

Loop MakeLoop(Random& random, int length, double noise) {
  Loop loop;
  std::vector<RigidTransform> poses;
  for (int s = 0; s < length; ++s) poses.push_back(RandomTransform(random, 20.0));
  for (int s = 0; s < length; ++s) {
    PoseGraphLink link;
    link.source = (s + 1) % length, link.target = s;
    if (random.Uniform() < 0.5) std::swap(link.source, link.target);
    link.target_from_source = Retract(poses[static_cast<std::size_t>(link.target)].Inverse() *
                                          poses[static_cast<std::size_t>(link.source)],
                                      RandomTwist(random, noise, noise));
    const Vector6d scale = 1e-3 * (Vector6d::Ones() + RandomTwist(random, 0.5, 0.5));
    const Matrix6d mix = Matrix6d::Identity() + 0.1 * RandomTwist(random, 1.0, 1.0) *
                                                    RandomTwist(random, 1.0, 1.0).transpose();
    const Matrix6d root = mix * scale.asDiagonal();
    link.information = (root * root.transpose()).inverse();
    loop.links.push_back(link);
    loop.order.push_back(s);
  }
  return loop;
}

TEST(CloseLoop, TrueMotionsClose) {
  Random random(1);
  for (const int length : {2, 3, 4, 7}) {
    const Loop loop = MakeLoop(random, length, 0.0);
    const Misclosure closed = CloseLoop(loop.links, Covariances(loop.links), loop.order, 0);
    EXPECT_LT(closed.value.norm(), 1e-12);
  }
}

TEST(CloseLoop, CovarianceHasTheDerivativesOfFiniteDifferences) {
  // Also far from closing: the derivative at the misclosure, not at the identity.
  Random random(2);
  const double h = 1e-6;
  for (int round = 0; round < 20; ++round) {
    Loop loop = MakeLoop(random, 3 + round % 2, 0.4);
    const auto covariances = Covariances(loop.links);
    Matrix6d expected = Matrix6d::Zero();
    for (std::size_t l = 0; l < loop.links.size(); ++l) {
      const RigidTransform motion = loop.links[l].target_from_source;
      Matrix6d jacobian;
      for (int i = 0; i < 6; ++i) {
        const auto at = [&](double step) {
          loop.links[l].target_from_source = Retract(motion, step * Vector6d::Unit(i));
          return CloseLoop(loop.links, covariances, loop.order, 0).value;
        };
        jacobian.col(i) = (at(h) - at(-h)) / (2.0 * h);
      }
      loop.links[l].target_from_source = motion;
      expected += jacobian * covariances[l] * jacobian.transpose();
    }
    const Matrix6d actual = CloseLoop(loop.links, covariances, loop.order, 0).covariance;
    EXPECT_LT((actual - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(CloseLoop, SquaredErrorIsChiSquaredOfSixDegrees) {
  Random random(3);
  const Loop truth = MakeLoop(random, 3, 0.0);
  const auto covariances = Covariances(truth.links);
  constexpr int kDraws = 4000;
  double mean = 0.0;
  int beyond = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Loop loop = truth;
    for (std::size_t l = 0; l < loop.links.size(); ++l) {
      Vector6d normal;
      for (double& x : normal) x = random.Normal();
      const Matrix6d root = covariances[l].llt().matrixL();
      loop.links[l].target_from_source = Retract(loop.links[l].target_from_source, root * normal);
    }
    const double e = CloseLoop(loop.links, covariances, loop.order, 0).SquaredError();
    mean += e / kDraws;
    beyond += e > 16.81 ? 1 : 0;
  }
  // Standard errors: sqrt(12 / 4000) = 0.055, and sqrt(0.01 * 0.99 / 4000) = 0.0016.
  EXPECT_NEAR(mean, 6.0, 0.2);
  EXPECT_NEAR(beyond / static_cast<double>(kDraws), 0.01, 0.006);
}

TEST(CheckCycles, FindsEveryTriangleOnce) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto network = MakeNetwork(seed, 10, 0.4, 1.0);
    const CycleStatistics cycles = CheckCycles(10, network.links, {});
    std::size_t expected = 0;
    const auto joined = [&](int a, int b) {
      for (const PoseGraphLink& link : network.links) {
        if (std::minmax(link.source, link.target) == std::minmax(a, b)) return true;
      }
      return false;
    };
    for (int a = 0; a < 10; ++a) {
      for (int b = a + 1; b < 10; ++b) {
        for (int c = b + 1; c < 10; ++c) {
          expected += joined(a, b) && joined(b, c) && joined(a, c) ? 1 : 0;
        }
      }
    }
    std::size_t triangles = 0;
    for (const Cycle& cycle : cycles.cycles) triangles += cycle.links[3] < 0 ? 1 : 0;
    EXPECT_EQ(triangles, expected);
  }
}

TEST(CheckCycles, LinksOnNoTriangleAreOnLoopsOfFour) {
  // A square without diagonals, and a tail that is on no loop.
  auto network = MakeNetwork(5, 5, 0.0, 1.0);
  PoseGraphLink closing = network.links[0];
  closing.source = 0, closing.target = 3;
  closing.target_from_source =
      network.survey_from_station[3].Inverse() * network.survey_from_station[0];
  network.links.push_back(closing);
  const CycleStatistics cycles = CheckCycles(5, network.links, {});
  for (const std::size_t l : {0U, 1U, 2U, 4U}) EXPECT_EQ(cycles.support[l].valid, 1) << l;
  EXPECT_EQ(cycles.support[3].valid + cycles.support[3].invalid, 0);
}

TEST(CheckCycles, FalseLinksCloseNoCycle) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto network = MakeTown(seed, 30, 8, 1.0);
    const auto is_false = ReplaceByRandom(seed, 0.3, &network.links);
    const CycleStatistics cycles = CheckCycles(30, network.links, {});
    for (std::size_t l = 0; l < network.links.size(); ++l) {
      if (is_false[l] != 0) {
        EXPECT_EQ(cycles.support[l].valid, 0) << seed << " link " << l;
      }
    }
    EXPECT_LT(cycles.scale.factor, 1.6);
  }
}

TEST(CheckCycles, VarianceFactorIsThatOfTheErrors) {
  for (const double scale : {1.0, 2.0, 4.0}) {
    double mean = 0.0;
    constexpr int kSeeds = 10;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      auto network = MakeTown(seed, 40, 8, scale);
      for (PoseGraphLink& link : network.links) link.information *= scale * scale;
      ReplaceByRandom(seed, 0.3, &network.links);
      mean += CheckCycles(40, network.links, {}).scale.factor / kSeeds;
    }
    EXPECT_GT(mean, 0.85 * scale * scale);
    EXPECT_LT(mean, 1.2 * scale * scale);
  }
}

TEST(CheckCycles, RivalsOfAPairDoNotCountAsContradictions) {
  const auto hall = MakeHall(1, 5, 0.1, 0.0);
  const CycleStatistics cycles = CheckCycles(5, hall.links, {});
  for (const LinkSupport& support : cycles.support) {
    EXPECT_EQ(support.valid, 3);
    EXPECT_EQ(support.invalid, 0);
  }
}

TEST(EstimateScale, FewLoopsAreNotBelievedToBeVeryNoisy) {
  EXPECT_EQ(EstimateScale({1e5}, {}).factor, 25.0);
  EXPECT_EQ(EstimateScale(std::vector<double>(9, 40.0 * 5.348), {}).factor, 25.0);
  EXPECT_NEAR(EstimateScale(std::vector<double>(10, 40.0 * 5.348), {}).factor, 40.0, 1e-9);
  EXPECT_EQ(EstimateScale(std::vector<double>(50, 1e5), {}).factor, 100.0);
  EXPECT_EQ(EstimateScale(std::vector<double>(50, 1.0), {}).factor, 1.0);
}

TEST(CheckCycles, EmptyInput) {
  EXPECT_TRUE(CheckCycles(0, {}, {}).cycles.empty());
  EXPECT_EQ(CheckCycles(3, {}, {}).scale.factor, 1.0);
}

}  // namespace
}  // namespace backsight
