#include "stages/network_solution.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/stages/synthetic_links.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

TEST(SolveNetwork, TwoComponentsStayTwo) {
  const auto a = MakeNetwork(3, 4, 1.0, 1.0);
  auto b = MakeNetwork(4, 5, 1.0, 1.0);
  SyntheticNetwork both = a;
  both.survey_from_station.resize(10);
  for (PoseGraphLink link : b.links) {
    link.source += 4, link.target += 4;
    both.links.push_back(link);
  }
  const auto result = Solve(both);
  EXPECT_EQ(result.poses.component, (std::vector<int>{0, 0, 0, 0, 1, 1, 1, 1, 1, 2}));
  EXPECT_EQ(result.redundancy, 6 * (6 + 10 - 3 - 4));
  for (const std::size_t s : {0U, 4U, 9U}) {
    EXPECT_EQ(result.poses.covariance[s].norm(), 0.0);
    EXPECT_EQ(result.poses.survey_from_station[s].Matrix(), Eigen::Matrix4d::Identity().eval());
  }
}

TEST(SolveNetwork, TheOrderOfTheLinksDoesNotMatter) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    auto network = MakeTown(seed, 25, 8, 1.0);
    ReplaceByRandom(seed, 0.3, &network.links);
    SyntheticNetwork shuffled = network;
    std::vector<std::size_t> order;
    for (std::size_t l = 0; l < network.links.size(); ++l) order.push_back(l);
    Random random(seed);
    for (std::size_t l = order.size(); l-- > 1;) std::swap(order[l], order[random.Index(l + 1)]);
    for (std::size_t l = 0; l < order.size(); ++l) shuffled.links[l] = network.links[order[l]];
    const auto a = Solve(network);
    const auto b = Solve(shuffled);
    for (std::size_t l = 0; l < order.size(); ++l) EXPECT_EQ(b.fate[l], a.fate[order[l]]);
    EXPECT_LT(LargestDistance(a.poses.survey_from_station, b.poses.survey_from_station), 1e-7);
  }
}

TEST(ResidualInSigmas, IsOneWhereTheCovarianceIsRight) {
  const NetworkOptions options;
  const double floor_rad = options.floor_rotation_deg * std::numbers::pi / 180.0;
  Random random(11);
  double squares = 0.0;
  constexpr int kLinks = 3000;
  for (int i = 0; i < kLinks; ++i) {
    // A claim of its own in every direction, and the systematic error on top of it.
    Matrix6d mixing = Matrix6d::Identity();
    for (double& value : mixing.reshaped()) value += 0.3 * random.Normal();
    Vector6d unit;
    for (double& value : unit) value = random.Normal();
    mixing *= 0.001;
    Vector6d error = mixing * unit;
    for (int k = 0; k < 6; ++k) {
      error[k] += (k < 3 ? floor_rad : options.floor_translation_m) * random.Normal();
    }
    NetworkLink link;
    link.information = (mixing * mixing.transpose()).inverse();
    link.target_from_source = RandomTransform(random, 20.0);
    const RigidTransform truth = Retract(link.target_from_source, error);
    squares += std::pow(ResidualInSigmas(link, truth, options), 2) / kLinks;
  }
  EXPECT_NEAR(squares, 1.0, 0.05);
}

TEST(SolveNetwork, NormalisedErrorsAreOne) {
  // With errors as stated, and with all of them three times as large as stated.
  for (const double scale : {1.0, 3.0}) {
    double nees = 0.0;
    double link_nees = 0.0;
    int links = 0;
    double factor = 0.0;
    constexpr int kSeeds = 30;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      auto network = MakeTown(seed, 14, 6, scale);
      for (PoseGraphLink& link : network.links) link.information *= scale * scale;
      const auto result = Solve(network);
      factor += result.sigma_factor / kSeeds;
      const Eigen::Index free = 6 * 13;
      Eigen::VectorXd error(free);
      for (std::size_t s = 1; s < 14; ++s) {
        error.segment<6>(6 * (static_cast<Eigen::Index>(s) - 1)) =
            LocalDifference(result.poses.survey_from_station[s], network.survey_from_station[s]);
      }
      nees += error.dot(result.covariance.bottomRightCorner(free, free).ldlt().solve(error)) /
              static_cast<double>(free * kSeeds);
      for (std::size_t l = 0; l < network.links.size(); ++l) {
        const PoseGraphLink& link = network.links[l];
        const auto relative = [&](const std::vector<RigidTransform>& poses) {
          return poses[static_cast<std::size_t>(link.target)].Inverse() *
                 poses[static_cast<std::size_t>(link.source)];
        };
        const Vector6d off = LocalDifference(relative(result.poses.survey_from_station),
                                             relative(network.survey_from_station));
        link_nees += off.dot(result.link_covariance[l].inverse() * off);
        links += 6;
      }
    }
    std::printf("errors %.0f times as stated: sigma factor %.3f, NEES %.3f, of links %.3f\n", scale,
                factor, nees, link_nees / links);
    EXPECT_GT(nees, 0.8);
    EXPECT_LT(nees, 1.2);
    EXPECT_GT(link_nees / links, 0.8);
    EXPECT_LT(link_nees / links, 1.2);
    EXPECT_NEAR(factor, scale, 0.1 * scale);
  }
}

TEST(SolveNetwork, ClosuresAreThoseOfTheMeasuredTriangles) {
  const auto network = MakeNetwork(6, 5, 1.0, 1.0);
  const auto result = Solve(network);
  EXPECT_EQ(result.closures.size(), 10U);
  for (const TriangleClosure& closure : result.closures) {
    EXPECT_LT(closure.a, closure.b);
    EXPECT_LT(closure.b, closure.c);
    EXPECT_GT(closure.translation_m, 0.0);
    EXPECT_LT(closure.translation_m, 0.2);
  }
}

TEST(SolveNetwork, TheFloorHoldsErrorsUp) {
  const auto network = MakeNetwork(7, 4, 1.0, 0.0);
  auto links = ToNetworkLinks(network.links);
  for (NetworkLink& link : links) link.information *= 1e6;
  NetworkOptions options;
  options.floor_translation_m = 0.002;
  const auto result = SolveNetwork(4, links, options);
  // A full network of four: a station's variance relative to another is half that of a link.
  for (std::size_t s = 1; s < 4; ++s) {
    const Matrix6d& covariance = result.link_covariance[s];
    EXPECT_NEAR(std::sqrt(covariance(5, 5)), 0.002 / std::sqrt(2.0), 4e-4);
  }
}

TEST(SolveNetwork, NotRobustUsesEveryLink) {
  auto network = MakeNetwork(8, 6, 1.0, 1.0);
  ReplaceByRandom(8, 0.2, &network.links);
  network.links[0].doubtful = true;
  NetworkOptions options = Exact();
  options.robust = false;
  const auto result = Solve(network, options);
  EXPECT_EQ(Count(result, LinkFate::kUsed), 15);
}

TEST(SolveNetwork, FewLinks) {
  const auto pair = MakeNetwork(9, 2, 1.0, 1.0);
  const auto result = Solve(pair);
  EXPECT_EQ(result.fate[0], LinkFate::kUsed);
  EXPECT_FALSE(result.loop_controlled[0]);
  EXPECT_EQ(result.sigma_factor, 1.0);
  EXPECT_EQ(result.redundancy, 0);
  EXPECT_EQ(SolveNetwork(0, {}, {}).poses.survey_from_station.size(), 0U);
  const auto alone = SolveNetwork(3, {}, {});
  EXPECT_EQ(alone.poses.component, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(alone.poses.covariance.size(), 3U);
}

TEST(SolveNetwork, InformationThatIsSingularGivesNoFalseCertainty) {
  // Corridor: one link knows nothing of the direction along it.
  auto network = MakeNetwork(10, 3, 0.0, 0.0);
  Vector6d known = Vector6d::Constant(1e6);
  known[3] = 0.0;
  network.links[1].information = known.asDiagonal();
  const auto result = Solve(network);
  EXPECT_NEAR(result.weakest.station_m, 1.0, 0.1) << "the least that is assumed";
  EXPECT_EQ(result.weakest.station, 2);
}

TEST(SolveNetwork, BigTownsAreSolved) {
  for (const auto& [stations, degree] : {std::pair{200, 16}, std::pair{500, 16}}) {
    auto network = MakeTown(11, stations, degree, 1.0);
    const auto is_false = ReplaceByRandom(11, 0.3, &network.links);
    const auto start = std::chrono::steady_clock::now();
    const auto result = Solve(network);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("%d stations, %zu links: %.1f s, %d removed, %d readmitted, %d moves\n", stations,
                network.links.size(), seconds.count(), result.removed, result.readmitted,
                result.moves);
    EXPECT_EQ(result.poses.component, std::vector<int>(static_cast<std::size_t>(stations), 0));
    for (std::size_t l = 0; l < is_false.size(); ++l) {
      EXPECT_EQ(result.fate[l] == LinkFate::kUsed, is_false[l] == 0);
    }
  }
}

}  // namespace
}  // namespace backsight
