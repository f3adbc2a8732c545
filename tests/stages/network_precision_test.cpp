#include "stages/network_precision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "graph/planar_adjustment.h"
#include "stages/principal_motions.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Poses = std::vector<RigidTransform>;

/// Patches on the walls of a room. `claim`: how many times better than they are the errors of those
/// that face x are claimed to be.
SyntheticPlanes Room(std::uint64_t seed, double claim) {
  SyntheticPlanes room = MakePlanes(seed, {.stations = 3,
                                           .planes = 240,
                                           .noise_m = 0.004,
                                           .normals = SyntheticPlaneOptions::Normals::kBox});
  for (WeightedPlane& plane : room.planes) {
    const Eigen::Matrix3d scatter = JointCluster(plane, room.world_from_station).scatter;
    Eigen::Index across = 0;
    scatter.diagonal().minCoeff(&across);
    if (across == 0) plane.weight *= claim * claim;
  }
  return room;
}

NetworkPrecision PrecisionOf(const SyntheticPlanes& room, const Poses& poses, int threads = 1) {
  return ComputePrecision({room.planes, {}, {}, poses}, {}, ExecutionContext(threads));
}

Poses Adjust(const SyntheticPlanes& room) {
  return AdjustPlanes(room.planes, {}, room.world_from_station, 0, {}).poses;
}

/// Mean squared error of the stations' positions over what is stated, per axis.
Eigen::Array3d SquaredErrors(double claim, bool with_variance_factor_alone) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SyntheticPlanes room = Room(seed, claim);
    const Poses poses = Adjust(room);
    const NetworkPrecision precision = PrecisionOf(room, poses);
    EXPECT_TRUE(precision.valid);
    Eigen::MatrixXd covariance = precision.covariance;
    if (with_variance_factor_alone) {
      covariance = precision.variance_factor *
                   InvertInformation(AssembleNormalEquations(room.planes, {}, poses).matrix);
    }
    for (std::size_t s = 1; s < 3; ++s) {
      const RigidTransform& truth = room.world_from_station[s];
      Eigen::Matrix<double, 3, 6> position;  // by left perturbations
      position << -Skew(poses[s].translation), Eigen::Matrix3d::Identity();
      const auto row = static_cast<Eigen::Index>(6 * s);
      const Eigen::Matrix3d stated =
          position * covariance.block<6, 6>(row, row) * position.transpose();
      const Eigen::Array3d error = poses[s].translation - truth.translation;
      sum += error.square() / stated.diagonal().array() / (2.0 * kSeeds);
    }
  }
  return sum;
}

TEST(NetworkPrecision, StatesErrorsAsTheyAreWhereWeightsAreHonest) {
  const Eigen::Array3d squared = SquaredErrors(1.0, false);
  EXPECT_GT(squared.minCoeff(), 0.5);
  EXPECT_LT(squared.maxCoeff(), 1.4);
}

TEST(NetworkPrecision, StatesErrorsOfTheDirectionWhoseSurfacesClaimTooMuch) {
  // What one factor for all directions makes of it, and what is made of it.
  EXPECT_GT(SquaredErrors(5.0, true).x(), 2.0);
  const Eigen::Array3d squared = SquaredErrors(5.0, false);
  EXPECT_LT(squared.x(), 1.6);
  EXPECT_LT(squared.maxCoeff(), 1.6);
}

TEST(NetworkPrecision, WhatOnlyALinkHoldsIsStatedAboutAsTheLinkHasIt) {
  // Patches of two opposite walls, and a link that knows shifts to 0.25 m.
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SyntheticPlanes scene =
        MakePlanes(seed, {.stations = 2,
                          .planes = 100,
                          .noise_m = 0.004,
                          .normals = SyntheticPlaneOptions::Normals::kParallel});
    PoseGraphLink link;
    link.source = 1;
    link.target = 0;
    link.target_from_source = scene.world_from_station[1];
    Vector6d information;
    information << Eigen::Vector3d::Constant(1e4), Eigen::Vector3d::Constant(16.0);
    link.information = information.asDiagonal();
    const std::vector<PoseGraphLink> links{link};
    const Poses poses =
        AdjustPlanes({scene.planes, {{}, links, {}}, nullptr}, scene.world_from_station, 0, {})
            .poses;
    const NetworkPrecision precision =
        ComputePrecision({scene.planes, {}, {{}, links, {}}, poses}, {}, ExecutionContext(1));
    ASSERT_TRUE(precision.valid) << seed;
    const double sigma_m = std::sqrt(precision.covariance(9, 9));
    EXPECT_GT(sigma_m, 0.02) << seed;
    EXPECT_LT(sigma_m, 2.0) << seed << ": eight times what the link says";
  }
}

TEST(NetworkPrecision, APlaneThatAloneHoldsAMotionDoesNotMakeItsSigmaMetres) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SyntheticPlanes room = Room(seed, 1.0);
    bool has_one = false;
    std::erase_if(room.planes, [&](const WeightedPlane& plane) {
      const Eigen::Matrix3d scatter = JointCluster(plane, room.world_from_station).scatter;
      Eigen::Index across = 0;
      scatter.diagonal().minCoeff(&across);
      const bool more = across == 0 && has_one;
      has_one = has_one || (across == 0 && plane.observations.size() == 3);
      return more || (across == 0 && plane.observations.size() < 3);
    });
    ASSERT_TRUE(has_one);
    const NetworkPrecision precision = PrecisionOf(room, Adjust(room));
    if (!precision.valid) continue;
    EXPECT_LT(std::sqrt(precision.covariance.diagonal().maxCoeff()), 0.1) << seed;
  }
}

TEST(NetworkPrecision, TheWeakestMotionIsTheLargestOfTheCovariance) {
  const SyntheticPlanes room = Room(5, 5.0);
  const Poses poses = Adjust(room);
  const NetworkPrecision precision = PrecisionOf(room, poses);
  const PrincipalMotions motions = FindPrincipalMotions(room.planes, poses, precision.covariance);
  EXPECT_NEAR(precision.weakest.sigma_m, motions.sigmas_m.maxCoeff(),
              0.1 * motions.sigmas_m.maxCoeff());
  EXPECT_NEAR(precision.weakest.direction.norm(), 1.0, 1e-12);
  EXPECT_GE(precision.weakest.station, 1);
}

TEST(NetworkPrecision, ThreadsDoNotChangeABit) {
  const SyntheticPlanes room = Room(6, 3.0);
  const Poses poses = Adjust(room);
  EXPECT_EQ(PrecisionOf(room, poses, 1).covariance, PrecisionOf(room, poses, 4).covariance);
}

TEST(PrincipalMotions, MakeUpTheCovarianceAndAreIndependent) {
  const SyntheticPlanes room = Room(7, 1.0);
  const Poses poses = Adjust(room);
  const Eigen::MatrixXd covariance =
      InvertInformation(AssembleNormalEquations(room.planes, {}, poses).matrix);
  const PrincipalMotions motions = FindPrincipalMotions(room.planes, poses, covariance);
  ASSERT_EQ(motions.sigmas_m.size(), 12);
  const Eigen::MatrixXd again = motions.steps * motions.steps.transpose();
  EXPECT_LT((again - covariance).norm(), 1e-9 * covariance.norm());
  const Eigen::MatrixXd unit = motions.directions.transpose() * motions.directions;
  EXPECT_LT((unit - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-12);
  for (Eigen::Index i = 1; i < 12; ++i) EXPECT_LE(motions.sigmas_m[i - 1], motions.sigmas_m[i]);
}

TEST(PrincipalMotions, TurnsCountByTheShiftAtThePlanes) {
  // Station 1 sees four patches at the corners of a square about (5, 0, 0); a turn about its
  // centre.
  std::vector<WeightedPlane> planes;
  const Eigen::Vector3d center(5.0, 0.0, 0.0);
  for (const double x : {-3.0, 3.0}) {
    for (const double y : {-4.0, 4.0}) {
      const PointCluster patch = ClusterOf({center + Eigen::Vector3d(x, y, 0.0)});
      planes.push_back({{{0, patch}, {1, patch}}, 1.0});
    }
  }
  const double angle = 1e-3;
  Vector6d turn;
  turn << 0.0, 0.0, angle, -Eigen::Vector3d::UnitZ().cross(center) * angle;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(12, 12);
  covariance.bottomRightCorner<6, 6>() = turn * turn.transpose();
  const PrincipalMotions motions = FindPrincipalMotions(planes, Poses(2), covariance);
  EXPECT_NEAR(motions.sigmas_m.maxCoeff(), 5.0 * angle, 1e-9);
  EXPECT_NEAR(std::abs(motions.directions(8, 5)), 1.0, 1e-9);
  EXPECT_LT(motions.sigmas_m[4], 1e-6);
}

}  // namespace
}  // namespace backsight
