#include "stages/surface_links.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/support/matchers.h"

namespace backsight {
namespace {

constexpr double kVoxel = 0.1;    // m
constexpr double kNoise = 0.002;  // m, across the surface

struct Patch {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
};

/// Spheres about the world's origin, with patches so far apart that each has a voxel of its own.
std::vector<Patch> Spheres() {
  std::vector<Patch> patches;
  for (const Eigen::Vector3d& center :
       {Eigen::Vector3d(6.0, 0.0, 0.5), {-2.0, 5.0, -1.0}, {-3.0, -5.0, 1.0}, {1.0, 1.0, 4.0}}) {
    constexpr int kPatches = 700;
    constexpr double kRadius = 2.0;  // m
    for (int i = 0; i < kPatches; ++i) {
      const double z = 1.0 - (2.0 * i + 1.0) / kPatches;
      const double azimuth = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
      const double radius = std::sqrt(1.0 - z * z);
      const Eigen::Vector3d normal(radius * std::cos(azimuth), radius * std::sin(azimuth), z);
      patches.push_back({center + kRadius * normal, normal});
    }
  }
  return patches;
}

/// Two stations that measured the same patches, each with errors of its own across the surface.
struct TwoStations {
  TwoStations(std::uint64_t seed, const std::vector<Patch>& patches, double noise_m) {
    Random random(seed);
    for (std::size_t s = 0; s < 2; ++s) {
      poses.push_back(RandomTransform(random, 3.0));
      models[s].leaves = VoxelLeaves({.edge_m = kVoxel});
      const RigidTransform station_from_survey = poses.back().Inverse();
      for (const Patch& patch : patches) {
        PointCluster cluster;
        cluster.count = 1.0;
        cluster.mean =
            station_from_survey * (patch.point + noise_m * random.Normal() * patch.normal);
        models[s].leaves.Add(models[s].lattice().Key(cluster.mean), cluster);
        normals[s].push_back((station_from_survey.rotation * patch.normal).cast<float>());
      }
    }
    links[0].source = 1;
    links[0].target = 0;
  }

  RigidTransform Truth() const { return poses[0].Inverse() * poses[1]; }

  SurfaceObservations Observe(
      double information_factor = 1.0, int threads = 1,
      const std::function<bool(std::size_t, std::size_t)>& covered = nullptr) const {
    const ExecutionContext context(threads);
    const StationModel* const stations[] = {&models[0], &models[1]};
    const std::vector<Eigen::Vector3f>* const all_normals[] = {&normals[0], &normals[1]};
    const auto none = [](std::size_t, std::size_t) { return false; };
    const SurfaceMatcher matcher(stations, all_normals, covered ? covered : none, context);
    return matcher.Observe(links, poses, 0.8, information_factor, context);
  }

  std::array<StationModel, 2> models;
  std::array<std::vector<Eigen::Vector3f>, 2> normals;
  std::vector<RigidTransform> poses;
  std::array<PoseGraphLink, 1> links;
};

/// Gradient and Hessian at 0 by central differences.
template <class Function>
std::pair<Vector6d, Matrix6d> Differentiate(const Function& f, double step) {
  Vector6d gradient;
  Matrix6d hessian;
  const auto at = [&](int i, double a, int j, double b) {
    Vector6d x = Vector6d::Zero();
    x[i] += a * step;
    x[j] += b * step;
    return f(x);
  };
  for (int i = 0; i < 6; ++i) {
    gradient[i] = (at(i, 0.5, i, 0.5) - at(i, -0.5, i, -0.5)) / (2.0 * step);
    for (int j = 0; j < 6; ++j) {
      hessian(i, j) = (at(i, 1, j, 1) - at(i, 1, j, -1) - at(i, -1, j, 1) + at(i, -1, j, -1)) /
                      (4.0 * step * step);
    }
  }
  return {gradient, hessian};
}

/// Largest difference of two positive matrices' quadratic forms, relative to the second.
double RelativeDifference(const Matrix6d& a, const Matrix6d& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> solver(a - b, b);
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

TEST(SurfaceMatcher, LinkHasNoResidualAtTheTruePose) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const TwoStations two(seed, Spheres(), 0.0);
    const SurfaceObservations found = two.Observe();
    ASSERT_EQ(found.links.size(), 1U);
    EXPECT_EQ(found.matches, 2800);
    EXPECT_EQ(found.links[0].source, 1);
    EXPECT_EQ(found.links[0].target, 0);
    const Vector6d residual = LinkResidual(found.links[0], two.poses[1], two.poses[0]);
    EXPECT_LT(residual.norm(), 1e-7) << "seed " << seed;
  }
}

TEST(SurfaceMatcher, LinkComesBackToTheTruthFromBeside) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    TwoStations two(seed, Spheres(), 0.0);
    const RigidTransform truth = two.Truth();
    Random random(seed + 100);
    two.poses[1] = Retract(two.poses[1], RandomTwist(random, 5e-4, 0.003));
    const SurfaceObservations found = two.Observe();
    ASSERT_EQ(found.links.size(), 1U);
    // One Gauss-Newton step: second order of the disturbance is left.
    EXPECT_TRANSFORM_NEAR(found.links[0].target_from_source, truth, 2e-5, 2e-4) << seed;
  }
}

TEST(SurfaceMatcher, InformationIsTheCurvatureOfThePointToPlaneCost) {
  // With voxels fifty times as wide as the noise only the distance across the surface counts.
  const std::vector<Patch> patches = Spheres();
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const TwoStations two(seed, patches, kNoise);
    const RigidTransform truth = two.Truth();
    const auto cost = [&](const Vector6d& xi) {
      const RigidTransform target_from_source = Retract(truth, xi);
      double sum = 0.0;
      for (std::size_t i = 0; i < patches.size(); ++i) {
        const Eigen::Vector3d difference =
            target_from_source * two.models[1].leaves.Mean(i) - two.models[0].leaves.Mean(i);
        const double across = difference.dot(two.normals[0][i].cast<double>());
        sum += 0.5 * across * across / (2.0 * kNoise * kNoise);
      }
      return sum;
    };
    const Matrix6d hessian = Differentiate(cost, 1e-4).second;
    const SurfaceObservations found = two.Observe();
    ASSERT_EQ(found.links.size(), 1U);
    // The noise is estimated from the median of 2800 distances: its square is good to some 4 %.
    EXPECT_LT(RelativeDifference(found.links[0].information, hessian), 0.1) << "seed " << seed;
    const SurfaceObservations weighed = two.Observe(0.25);
    EXPECT_LT(RelativeDifference(4.0 * weighed.links[0].information, found.links[0].information),
              1e-9);
  }
}

TEST(SurfaceMatcher, InformationIsWhatRepeatedMeasurementsScatterBy) {
  const std::vector<Patch> patches = Spheres();
  constexpr int kSeeds = 100;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const TwoStations two(seed, patches, kNoise);
    const SurfaceObservations found = two.Observe();
    ASSERT_EQ(found.links.size(), 1U);
    const Vector6d error = LocalDifference(found.links[0].target_from_source, two.Truth());
    sum += error.dot(found.links[0].information * error) / 6.0;
  }
  // 600 degrees of freedom: a standard error of 0.058.
  EXPECT_NEAR(sum / kSeeds, 1.0, 0.2);
}

TEST(SurfaceMatcher, BlocksPullAsTheLinkDoes) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    TwoStations two(seed, Spheres(), kNoise);
    Random random(seed + 200);
    two.poses[1] = Retract(two.poses[1], RandomTwist(random, 2e-4, 0.001));
    const SurfaceObservations found = two.Observe();
    ASSERT_EQ(found.links.size(), 1U);
    ASSERT_GT(found.scores.size(), 20U);
    Vector6d gradient = Vector6d::Zero();
    Matrix6d matrix = Matrix6d::Zero();
    for (const LinkScore& score : found.scores) {
      EXPECT_EQ(score.source, 1);
      EXPECT_EQ(score.target, 0);
      gradient += score.gradient;
      matrix += score.matrix;
    }
    // What an adjustment sees of the link, moving the source or the target in the survey.
    const auto moved = [&](std::size_t station) {
      return [&, station](const Vector6d& xi) {
        std::vector<RigidTransform> poses = two.poses;
        poses[station] = Retract(poses[station], xi);
        return 0.5 * SquaredError(found.links[0], poses);
      };
    };
    const auto [of_source, hessian] = Differentiate(moved(1), 1e-4);
    const Vector6d of_target = Differentiate(moved(0), 1e-4).first;
    EXPECT_LT((gradient - of_source).norm(), 1e-2 * of_source.norm()) << "seed " << seed;
    EXPECT_LT((gradient + of_target).norm(), 1e-2 * of_source.norm()) << "seed " << seed;
    EXPECT_LT(RelativeDifference(hessian, matrix), 0.01) << "seed " << seed;
  }
}

TEST(SurfaceMatcher, ScoresKnowNothingAlongTheirSurfaces) {
  std::vector<Patch> level;
  for (int i = 0; i < 400; ++i) {
    level.push_back({{0.3 * (i / 20), 0.3 * (i % 20), 1.0}, Eigen::Vector3d::UnitZ()});
  }
  const TwoStations two(2, level, kNoise);
  const SurfaceObservations found = two.Observe();
  ASSERT_FALSE(found.scores.empty());
  Eigen::Matrix3d known = Eigen::Matrix3d::Zero();  // of shifts in the survey
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (const LinkScore& score : found.scores) {
    known += score.known.bottomRightCorner<3, 3>();
    matrix += score.matrix.bottomRightCorner<3, 3>();
  }
  EXPECT_NEAR(known(2, 2), matrix(2, 2), 1e-6 * matrix(2, 2));
  EXPECT_LT(known(0, 0) + known(1, 1), 1e-9 * known(2, 2));
  EXPECT_GT(matrix(0, 0) + matrix(1, 1), 1e-5 * matrix(2, 2)) << "what voxels seem to hold";
}

TEST(SurfaceMatcher, TakesOnlyWhatMatchesAndNoPlaneCovers) {
  const auto matches = [](const TwoStations& two) { return two.Observe().matches; };
  TwoStations two(1, Spheres(), kNoise);
  ASSERT_EQ(matches(two), 2800);
  const auto covered = [](std::size_t s, std::size_t i) { return s == 1 && i < 700; };
  EXPECT_EQ(two.Observe(1.0, 1, covered).matches, 2100);
  // Of the second sphere no normal is known, the third is seen from inside.
  for (std::size_t i = 700; i < 1400; ++i) {
    two.normals[1][i].setConstant(std::numeric_limits<float>::quiet_NaN());
    two.normals[1][i + 700] *= -1.0F;
  }
  EXPECT_EQ(matches(two), 1400);
  const RigidTransform there = two.poses[1];
  two.poses[1].translation.x() += 50.0;
  EXPECT_TRUE(two.Observe().links.empty());
  two.poses[1] = there;
  // A hundred matches are the fewest that observe anything.
  const auto all_but = [](std::size_t left) {
    return [left](std::size_t s, std::size_t i) { return s == 1 && i >= left; };
  };
  EXPECT_EQ(two.Observe(1.0, 1, all_but(100)).links.size(), 1U);
  const SurfaceObservations too_few = two.Observe(1.0, 1, all_but(99));
  EXPECT_TRUE(too_few.links.empty());
  EXPECT_TRUE(too_few.scores.empty());
  EXPECT_EQ(too_few.matches, 0);
}

}  // namespace
}  // namespace backsight
