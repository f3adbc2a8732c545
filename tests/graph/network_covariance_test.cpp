#include "graph/network_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

constexpr int kStations = 6;

Eigen::MatrixXd Joint(const SyntheticNetwork& network, const PoseGraphResult& result) {
  return JointCovariance(network.links, result.weights, FirstOfEachComponent(result.component),
                         result.survey_from_station);
}

TEST(JointCovariance, MatchesTheScatterOfSolutions) {
  constexpr int kSeeds = 60;
  double joint_nees = 0.0;
  double link_nees = 0.0;
  double chi2 = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto network = MakeNetwork(200 + seed, kStations, 0.7, 1.0);
    const auto result = SolvePoseGraph(kStations, network.links, {}, {.robust = false});
    const Eigen::MatrixXd joint = Joint(network, result);
    const Eigen::Index free = 6 * (kStations - 1);
    Eigen::VectorXd error(free);
    for (std::size_t s = 1; s < kStations; ++s) {
      error.segment<6>(6 * (static_cast<Eigen::Index>(s) - 1)) =
          LocalDifference(result.survey_from_station[s], network.survey_from_station[s]);
    }
    joint_nees += error.dot(joint.bottomRightCorner(free, free).ldlt().solve(error)) /
                  static_cast<double>(free * kSeeds);
    // Relative pose of stations 4 and 2, whether a link joins them or not.
    const auto relative = [](const std::vector<RigidTransform>& poses) {
      return poses[2].Inverse() * poses[4];
    };
    const Vector6d off = LocalDifference(relative(result.survey_from_station),
                                         relative(network.survey_from_station));
    const Matrix6d covariance = RelativeCovariance(joint, 4, 2, result.survey_from_station[2]);
    link_nees += off.dot(covariance.inverse() * off) / (6.0 * kSeeds);
    const double redundancy = 6.0 * (static_cast<double>(network.links.size()) - (kStations - 1));
    chi2 += 2.0 * result.cost / redundancy / kSeeds;
  }
  // Standard errors: sqrt(2 / (30 * 60)) = 0.033, sqrt(2 / (6 * 60)) = 0.075.
  EXPECT_NEAR(joint_nees, 1.0, 0.12);
  EXPECT_NEAR(link_nees, 1.0, 0.25);
  EXPECT_NEAR(chi2, 1.0, 0.12);
}

TEST(JointCovariance, OfATreeIsTheSumOfItsLinks) {
  const auto network = MakeNetwork(1, 4, 0.0, 1.0);
  const auto result = SolvePoseGraph(4, network.links, {}, {.robust = false});
  const Eigen::MatrixXd joint = Joint(network, result);
  Matrix6d sum = Matrix6d::Zero();
  for (const PoseGraphLink& link : network.links) {
    const Matrix6d adjoint =
        Adjoint(result.survey_from_station[static_cast<std::size_t>(link.target)]);
    sum += adjoint * link.information.inverse() * adjoint.transpose();
  }
  const Matrix6d last = joint.block<6, 6>(18, 18);
  EXPECT_LT((last - sum).norm(), 1e-6 * sum.norm());
  EXPECT_EQ((joint.block<6, 6>(0, 0).norm()), 0.0);
  EXPECT_LT((joint - joint.transpose()).norm(), 1e-15);
}

TEST(JointCovariance, ComponentsKnowNothingOfEachOther) {
  auto network = MakeNetwork(2, 6, 1.0, 1.0);
  std::erase_if(network.links,
                [](const PoseGraphLink& link) { return (link.source < 3) != (link.target < 3); });
  const auto result = SolvePoseGraph(6, network.links, {}, {.robust = false});
  const Eigen::MatrixXd joint = Joint(network, result);
  EXPECT_EQ(joint.topRightCorner(18, 18).norm(), 0.0);
  EXPECT_EQ((joint.block<6, 6>(18, 18).norm()), 0.0) << "the datum of the second component";
  EXPECT_GT((joint.block<6, 6>(24, 24).norm()), 0.0);
}

TEST(FindWeakestDirection, EqualsTheLargestEigenvalue) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto network = MakeTown(seed, 12, 5, 1.0);
    const auto result = SolvePoseGraph(12, network.links, {}, {.robust = false});
    const Eigen::MatrixXd joint = Joint(network, result);
    const auto weakest = FindWeakestDirection(joint, network.links, result.survey_from_station);
    Eigen::MatrixXd carry = Eigen::MatrixXd::Zero(72, 72);
    for (std::size_t s = 0; s < 12; ++s) {
      const auto i = static_cast<Eigen::Index>(6 * s);
      carry.block<3, 3>(i, i) = weakest.lever_m * Eigen::Matrix3d::Identity();
      carry.block<3, 3>(i + 3, i) = -Skew(result.survey_from_station[s].translation);
      carry.block<3, 3>(i + 3, i + 3).setIdentity();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(carry * joint * carry.transpose());
    EXPECT_NEAR(weakest.sigma_m, std::sqrt(solver.eigenvalues()(71)), 1e-4 * weakest.sigma_m);
    EXPECT_GE(weakest.station, 1);
    EXPECT_LE(weakest.station_m, weakest.sigma_m);
  }
}

TEST(FindWeakestDirection, OfALooseEndIsItsLink) {
  // All is known to a millimetre but how far station 3 is along x.
  auto network = MakeNetwork(3, 4, 1.0, 0.0);
  std::erase_if(network.links,
                [](const PoseGraphLink& link) { return std::max(link.source, link.target) == 3; });
  PoseGraphLink loose;
  loose.source = 3, loose.target = 0;
  loose.target_from_source = network.survey_from_station[3];
  Vector6d sigma;
  sigma << 1e-5, 1e-5, 1e-5, 0.25, 1e-3, 1e-3;
  loose.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  network.links.push_back(loose);
  const auto result = SolvePoseGraph(4, network.links, {}, {.robust = false});
  const auto weakest =
      FindWeakestDirection(Joint(network, result), network.links, result.survey_from_station);
  EXPECT_EQ(weakest.station, 3);
  EXPECT_NEAR(weakest.station_m, 0.25, 0.01);
  EXPECT_GT(std::abs(weakest.axis.x()), 0.99);
}

TEST(FindWeakestDirection, NothingIsFree) {
  const std::vector<RigidTransform> poses(2);
  const Eigen::MatrixXd joint = JointCovariance({}, {}, {1, 1}, poses);
  EXPECT_EQ(FindWeakestDirection(joint, {}, poses).station, -1);
  EXPECT_EQ(FindWeakestDirection(JointCovariance({}, {}, {}, {}), {}, {}).station, -1);
}

}  // namespace
}  // namespace backsight
