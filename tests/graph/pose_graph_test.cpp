#include "graph/pose_graph.h"

#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

void ExpectPosesNear(const std::vector<RigidTransform>& actual,
                     const std::vector<RigidTransform>& expected, double tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t s = 0; s < actual.size(); ++s) {
    EXPECT_TRANSFORM_NEAR(actual[s], expected[s], tolerance, tolerance) << "station " << s;
  }
}

TEST(LinkResidual, FollowsTheRetractionOfThePlanarAdjustment) {
  Random random(1);
  const double h = 1e-6;
  for (int k = 0; k < 30; ++k) {
    const RigidTransform source = RandomTransform(random, 20.0);
    const RigidTransform target = RandomTransform(random, 20.0);
    PoseGraphLink link;
    link.target_from_source = Retract(target.Inverse() * source, RandomTwist(random, 0.3, 1.0));
    Matrix6d by_source;
    Matrix6d by_target;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      by_source.col(i) = (LinkResidual(link, Retract(source, step), target) -
                          LinkResidual(link, Retract(source, -step), target)) /
                         (2.0 * h);
      by_target.col(i) = (LinkResidual(link, source, Retract(target, step)) -
                          LinkResidual(link, source, Retract(target, -step))) /
                         (2.0 * h);
    }
    const Matrix6d expected =
        LocalDifferenceJacobian(LinkResidual(link, source, target)) * Adjoint(target.Inverse());
    EXPECT_LT((by_source - expected).norm(), 1e-6);
    EXPECT_LT((by_target + expected).norm(), 1e-6);
  }
}

TEST(LinkResidual, HasTheSignOfTheSourceStationsMotion) {
  // Target at the origin, measurement exact: moving the source by xi gives the residual xi.
  Random random(2);
  PoseGraphLink link;
  link.target_from_source = RandomTransform(random, 20.0);
  const Vector6d xi = RandomTwist(random, 0.1, 0.5);
  const Vector6d residual = LinkResidual(link, Retract(link.target_from_source, xi), {});
  EXPECT_LT((residual - xi).norm(), 1e-12);
}

TEST(SolvePoseGraph, ExactNetworkExactly) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto network = MakeNetwork(seed, 9, 0.5, 0.0);
    const auto result = SolvePoseGraph(9, network.links, {}, {});
    EXPECT_TRUE(result.converged);
    EXPECT_LT(result.cost, 1e-9);
    EXPECT_EQ(result.component, std::vector<int>(9, 0));
    EXPECT_EQ(result.weights, std::vector<double>(network.links.size(), 1.0));
    ExpectPosesNear(result.survey_from_station, network.survey_from_station, 1e-8);
  }
}

TEST(SolvePoseGraph, FalseLinksAreRemovedFromAStartThatIsNearby) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto network = MakeNetwork(seed, 12, 0.8, 1.0);
    const auto is_false = FalsifyLinks(seed, 0.3, &network.links);
    Random random(seed + 100);
    std::vector<RigidTransform> start = network.survey_from_station;
    for (RigidTransform& pose : start) pose = Retract(pose, RandomTwist(random, 0.02, 0.5));
    std::vector<PoseGraphLink> good;
    for (std::size_t l = 0; l < network.links.size(); ++l) {
      if (is_false[l] == 0) good.push_back(network.links[l]);
    }
    const auto result = SolvePoseGraph(12, network.links, start, {.outlier_limit = 35.0});
    const auto expected = SolvePoseGraph(12, good, {}, {.robust = false});
    EXPECT_TRUE(result.converged);
    for (std::size_t l = 0; l < network.links.size(); ++l) {
      EXPECT_EQ(result.weights[l], is_false[l] != 0 ? 0.0 : 1.0) << seed << " link " << l;
    }
    ExpectPosesNear(result.survey_from_station, expected.survey_from_station, 1e-6);
  }
}

TEST(SolvePoseGraph, NotRobustUsesEveryLink) {
  auto network = MakeNetwork(20, 6, 1.0, 1.0);
  FalsifyLinks(20, 0.2, &network.links);
  const auto result = SolvePoseGraph(6, network.links, {}, {.robust = false});
  EXPECT_EQ(result.weights, std::vector<double>(network.links.size(), 1.0));
  EXPECT_GT(result.cost, 1000.0);
}

TEST(SolvePoseGraph, TwoComponentsStayTwo) {
  const auto a = MakeNetwork(3, 4, 1.0, 0.0);
  const auto b = MakeNetwork(4, 5, 1.0, 0.0);
  std::vector<PoseGraphLink> links = a.links;
  for (PoseGraphLink link : b.links) {
    link.source += 4;
    link.target += 4;
    links.push_back(link);
  }
  const auto result = SolvePoseGraph(10, links, {}, {});
  EXPECT_EQ(result.component, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1, 1, 2}));
  auto expected = a.survey_from_station;
  expected.insert(expected.end(), b.survey_from_station.begin(), b.survey_from_station.end());
  expected.emplace_back();  // a station without links is a component of its own
  ExpectPosesNear(result.survey_from_station, expected, 1e-8);
}

TEST(SolvePoseGraph, StationsWithoutLinks) {
  const auto result = SolvePoseGraph(3, {}, {}, {});
  EXPECT_EQ(result.component, (std::vector<int>{0, 1, 2}));
  ExpectPosesNear(result.survey_from_station, std::vector<RigidTransform>(3), 0.0);
  EXPECT_TRUE(SolvePoseGraph(0, {}, {}, {}).survey_from_station.empty());
}

TEST(SolvePoseGraph, SemiDefiniteInformationIsUsedAsItIs) {
  // Each link knows nothing of one direction, as a corridor's does; together they know all.
  auto network = MakeNetwork(5, 6, 1.0, 0.0);
  Random random(5);
  for (PoseGraphLink& link : network.links) {
    const Vector6d blind = RandomTwist(random, 1.0, 1.0).normalized();
    const Matrix6d see = Matrix6d::Identity() - blind * blind.transpose();
    link.information = 1e6 * see;
    // What it does not know it measured badly.
    link.target_from_source = Retract(link.target_from_source, 0.01 * blind);
  }
  const auto result = SolvePoseGraph(6, network.links, {}, {.robust = false});
  double cost = 0.0;
  for (const PoseGraphLink& link : network.links) {
    const Vector6d r =
        LinkResidual(link, network.survey_from_station[static_cast<std::size_t>(link.source)],
                     network.survey_from_station[static_cast<std::size_t>(link.target)]);
    cost += 0.5 * r.dot(link.information * r);
  }
  EXPECT_LE(result.cost, cost * (1.0 + 1e-9)) << "the truth must not be better than the minimum";
  ExpectPosesNear(result.survey_from_station, network.survey_from_station, 1e-4);
}

}  // namespace
}  // namespace backsight
