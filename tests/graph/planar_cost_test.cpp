#include "graph/planar_cost.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "graph/planar_adjustment.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Poses = std::vector<RigidTransform>;

Poses Retracted(const Poses& poses, const Eigen::VectorXd& xi) {
  Poses moved = poses;
  for (std::size_t s = 0; s < poses.size(); ++s) {
    moved[s] = Retract(poses[s], xi.segment<6>(static_cast<Eigen::Index>(6 * s)));
  }
  return moved;
}

/// Central differences of PlanarCost.
Eigen::VectorXd NumericGradient(const std::vector<WeightedPlane>& planes,
                                const std::vector<PosePrior>& priors, const Poses& poses) {
  const double h = 1e-5;
  const auto n = static_cast<Eigen::Index>(6 * poses.size());
  Eigen::VectorXd gradient(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(n, i);
    gradient[i] = (PlanarCost(planes, priors, Retracted(poses, step)) -
                   PlanarCost(planes, priors, Retracted(poses, -step))) /
                  (2.0 * h);
  }
  return gradient;
}

Eigen::MatrixXd NumericHessian(const std::vector<WeightedPlane>& planes,
                               const std::vector<PosePrior>& priors, const Poses& poses, double h) {
  const auto n = static_cast<Eigen::Index>(6 * poses.size());
  const auto cost = [&](Eigen::Index i, double a, Eigen::Index j, double b) {
    Eigen::VectorXd xi = Eigen::VectorXd::Zero(n);
    xi[i] += a, xi[j] += b;
    return PlanarCost(planes, priors, Retracted(poses, xi));
  };
  Eigen::MatrixXd hessian(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      hessian(i, j) = hessian(j, i) =
          (cost(i, h, j, h) - cost(i, h, j, -h) - cost(i, -h, j, h) + cost(i, -h, j, -h)) /
          (4.0 * h * h);
    }
  }
  return hessian;
}

/// A scene away from its minimum.
struct Disturbance {
  SyntheticPlanes scene;
  Poses poses;
};

Disturbance DisturbedScene(std::uint64_t seed, int stations) {
  Random random(seed);
  Disturbance d;
  d.scene = MakePlanes(seed, {.stations = stations, .planes = 20, .noise_m = 0.01});
  d.poses = Disturbed(random, d.scene.world_from_station, -1, 0.02, 0.05);
  return d;
}

TEST(PlanarCost, GradientEqualsFiniteDifferences) {
  for (int stations = 2; stations <= 5; ++stations) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const auto [scene, poses] = DisturbedScene(10 * seed + 1, stations);
      const NormalEquations system = AssembleNormalEquations(scene.planes, {}, poses);
      EXPECT_NEAR(system.cost, PlanarCost(scene.planes, {}, poses), 1e-12 * system.cost);
      const Eigen::VectorXd numeric = NumericGradient(scene.planes, {}, poses);
      EXPECT_LT((numeric - system.gradient).norm(), 1e-6 * system.gradient.norm());
    }
  }
}

TEST(PlanarCost, IsTheWeightedMeanSquaredDistance) {
  // Two stations look at the plane z = 0 from identity poses; points at +-0.1 and 0.
  const WeightedPlane plane{{{0, ClusterOf({{0, 0, 0.1}, {5, 0, -0.1}, {0, 5, -0.1}, {5, 5, 0.1}})},
                             {1, ClusterOf({{0, 0, 0}, {5, 0, 0}, {0, 5, 0}, {5, 5, 0}})}},
                            3.0};
  const Poses poses(2);
  const std::vector<WeightedPlane> planes = {plane};
  EXPECT_NEAR(PlanarCost(planes, {}, poses), 3.0 * 0.01 / 2.0, 1e-12);
  EXPECT_NEAR(PlaneThicknesses(planes, poses).at(0), 0.01 / 2.0, 1e-12);
}

TEST(PlanarCost, CommonMotionChangesNothing) {
  Random random(2);
  const auto [scene, poses] = DisturbedScene(2, 4);
  const double cost = PlanarCost(scene.planes, {}, poses);
  for (int k = 0; k < 20; ++k) {
    const RigidTransform motion = RandomTransform(random, 30.0);
    Poses moved;
    for (const RigidTransform& pose : poses) moved.push_back(motion * pose);
    EXPECT_NEAR(PlanarCost(scene.planes, {}, moved), cost, 1e-9 * cost);
  }
}

TEST(PlanarCost, MatrixIsSemiDefiniteAndBlindToCommonMotion) {
  for (int stations = 2; stations <= 5; ++stations) {
    const auto [scene, poses] = DisturbedScene(3, stations);
    const NormalEquations system = AssembleNormalEquations(scene.planes, {}, poses);
    const double norm = system.matrix.norm();
    EXPECT_LT((system.matrix - system.matrix.transpose()).norm(), 1e-12 * norm);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(system.matrix);
    EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-12 * norm);
    // Exactly the six directions of the datum are free.
    EXPECT_LT(solver.eigenvalues()[5], 1e-9 * norm);
    EXPECT_GT(solver.eigenvalues()[6], 1e-7 * norm);
    Eigen::MatrixXd common(6 * stations, 6);
    for (int s = 0; s < stations; ++s) common.middleRows<6>(6 * s) = Matrix6d::Identity();
    EXPECT_LT((system.matrix * common).norm(), 1e-9 * norm);
    EXPECT_LT((common.transpose() * system.gradient).norm(), 1e-9 * system.gradient.norm());
  }
}

TEST(PlanarCost, MatrixIsCloseToTheHessianAtTheMinimum) {
  for (const int stations : {2, 3}) {
    const auto scene = MakePlanes(4, {.stations = stations, .planes = 30, .noise_m = 0.002});
    const auto result = AdjustPlanes(scene.planes, {}, scene.world_from_station, 0, {});
    const Eigen::MatrixXd matrix = AssembleNormalEquations(scene.planes, {}, result.poses).matrix;
    const Eigen::MatrixXd hessian = NumericHessian(scene.planes, {}, result.poses, 1e-5);
    EXPECT_LT((matrix - hessian).norm(), 0.03 * hessian.norm());
    // Also where the large rotational entries do not hide the translations.
    for (const int row : {3, 9}) {
      const Eigen::Matrix3d actual = matrix.block<3, 3>(row, 3);
      const Eigen::Matrix3d expected = hessian.block<3, 3>(row, 3);
      EXPECT_LT((actual - expected).norm(), 0.03 * expected.norm());
    }
  }
}

/// The matrix of exact curvature.
Eigen::MatrixXd ExactMatrix(const std::vector<WeightedPlane>& planes, const Poses& poses) {
  PlanarProblem problem{planes, {}, nullptr};
  problem.curvature = PlaneCurvature::kExact;
  return AssembleNormalEquations(problem, poses).matrix;
}

TEST(PlanarCost, ExactCurvatureEqualsFiniteDifferencesAnywhere) {
  for (int stations = 2; stations <= 4; ++stations) {
    const auto [scene, poses] = DisturbedScene(20 + static_cast<std::uint64_t>(stations), stations);
    const Eigen::MatrixXd hessian = NumericHessian(scene.planes, {}, poses, 1e-4);
    const Eigen::MatrixXd exact = ExactMatrix(scene.planes, poses);
    EXPECT_LT((exact - hessian).norm(), 1e-4 * hessian.norm()) << stations;
    const Eigen::MatrixXd gauss_newton = AssembleNormalEquations(scene.planes, {}, poses).matrix;
    EXPECT_GT((exact - gauss_newton).norm(), 1e-3 * hessian.norm()) << "the difference is tested";
  }
}

TEST(PlanarCost, OnlyGaussNewtonTakesErrorsOfNormalsForKnowledge) {
  // Nothing but patches of two opposite walls: of shifts along them nobody knows anything.
  double gauss_newton = 0.0;
  double exact = 0.0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SyntheticPlanes scene =
        MakePlanes(seed, {.stations = 2,
                          .planes = 100,
                          .noise_m = 0.01,
                          .normals = SyntheticPlaneOptions::Normals::kParallel});
    const Poses& truth = scene.world_from_station;
    gauss_newton += AssembleNormalEquations(scene.planes, {}, truth).matrix(9, 9);
    exact += ExactMatrix(scene.planes, truth)(9, 9);
  }
  EXPECT_GT(gauss_newton, 0.0);
  EXPECT_LT(std::abs(exact), 0.1 * gauss_newton);
}

TEST(PlanarCost, TwoStationBlocksEqualThoseOfALargerAssembly) {
  const auto [scene, poses] = DisturbedScene(5, 4);
  std::vector<WeightedPlane> all;
  std::vector<WeightedPlane> pair;
  for (const WeightedPlane& plane : scene.planes) {
    const auto& o = plane.observations;
    if (o.size() < 2) continue;
    all.push_back({{{1, o[0].cluster}, {3, o[1].cluster}}, plane.weight});
    pair.push_back({{{0, o[0].cluster}, {1, o[1].cluster}}, plane.weight});
  }
  const NormalEquations large = AssembleNormalEquations(all, {}, poses);
  const NormalEquations small = AssembleNormalEquations(pair, {}, Poses{poses[1], poses[3]});
  EXPECT_NEAR(large.cost, small.cost, 1e-12 * small.cost);
  const int station[] = {1, 3};
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(large.gradient.segment<6>(6 * station[i]), small.gradient.segment<6>(6 * i));
    for (int j = 0; j < 2; ++j) {
      EXPECT_EQ((large.matrix.block<6, 6>(6 * station[i], 6 * station[j])),
                (small.matrix.block<6, 6>(6 * i, 6 * j)));
    }
  }
  EXPECT_EQ(large.gradient.segment<6>(0).norm(), 0.0);
  EXPECT_EQ(large.matrix.middleRows<6>(12).norm(), 0.0);
}

TEST(PlanarCost, AnUnneededStationLeavesTheOthersAsTheyAre) {
  const auto [scene, poses] = DisturbedScene(6, 3);
  const NormalEquations all = AssembleNormalEquations(scene.planes, {}, poses);
  PlanarProblem problem{scene.planes, {}, nullptr};
  problem.unneeded_station = 1;
  const NormalEquations system = AssembleNormalEquations(problem, poses);
  EXPECT_EQ(system.cost, all.cost);
  for (const int i : {0, 1, 2}) {
    for (const int j : {0, 1, 2}) {
      const Matrix6d block = system.matrix.block<6, 6>(6 * i, 6 * j);
      const Matrix6d expected = all.matrix.block<6, 6>(6 * i, 6 * j);
      EXPECT_EQ(block, i == 1 || j == 1 ? Matrix6d(Matrix6d::Zero()) : expected);
    }
    const Vector6d gradient = system.gradient.segment<6>(6 * i);
    EXPECT_EQ(gradient, i == 1 ? Vector6d(Vector6d::Zero()) : all.gradient.segment<6>(6 * i));
  }
}

PosePrior RandomPrior(Random& random, int station, const RigidTransform& expected) {
  Matrix6d root;
  for (double& x : root.reshaped()) x = random.Normal();
  return {station, expected, root * root.transpose()};
}

TEST(PosePrior, GradientEqualsFiniteDifferences) {
  Random random(6);
  for (int k = 0; k < 20; ++k) {
    const Poses poses = {RandomTransform(random, 5.0), RandomTransform(random, 5.0)};
    const RigidTransform expected = Retract(poses[1], RandomTwist(random, 0.5, 1.0));
    const std::vector<PosePrior> priors = {RandomPrior(random, 1, expected)};
    const NormalEquations system = AssembleNormalEquations({}, priors, poses);
    EXPECT_NEAR(system.cost, PlanarCost({}, priors, poses), 1e-12 * system.cost);
    const Eigen::VectorXd numeric = NumericGradient({}, priors, poses);
    EXPECT_LT((numeric - system.gradient).norm(), 1e-6 * system.gradient.norm());
  }
}

TEST(PosePrior, MatrixIsTheHessianWhereThePriorIsMet) {
  Random random(7);
  const Poses poses = {RandomTransform(random, 5.0), RandomTransform(random, 5.0)};
  const std::vector<PosePrior> priors = {RandomPrior(random, 0, poses[0])};
  const NormalEquations system = AssembleNormalEquations({}, priors, poses);
  EXPECT_LT(system.gradient.norm(), 1e-12);
  EXPECT_LT((system.matrix.block<6, 6>(0, 0) - priors[0].information).norm(), 1e-9);
  const Eigen::MatrixXd hessian = NumericHessian({}, priors, poses, 1e-4);
  EXPECT_LT((hessian - system.matrix).norm(), 1e-5 * system.matrix.norm());
}

}  // namespace
}  // namespace backsight
