#include "graph/anderson_acceleration.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "core/random.h"

namespace backsight {
namespace {

Eigen::VectorXd RandomVector(Random& random, int n) {
  Eigen::VectorXd v(n);
  for (double& x : v) x = random.Normal();
  return v;
}

TEST(AndersonAccelerator, SolvesLinearFixedPointsInDimensionPlusOneSteps) {
  Random random(1);
  for (const int n : {1, 2, 4, 6}) {
    for (int round = 0; round < 10; ++round) {
      Eigen::MatrixXd a(n, n);
      for (double& x : a.reshaped()) x = random.Normal();
      a *= 0.9 / a.operatorNorm();
      const Eigen::VectorXd b = RandomVector(random, n);
      const Eigen::VectorXd fixed_point =
          (Eigen::MatrixXd::Identity(n, n) - a).partialPivLu().solve(b);
      AndersonAccelerator accelerator(n);
      Eigen::VectorXd x = RandomVector(random, n);
      for (int step = 0; step < n + 1; ++step) x = accelerator.Propose(x, a * x + b);
      EXPECT_LT((x - fixed_point).norm(), 1e-6 * (1.0 + fixed_point.norm())) << n;
    }
  }
}

TEST(AndersonAccelerator, WindowOneSolvesALineInTwoProposals) {
  for (const double slope : {0.9, -0.5, 0.999, 1.5}) {
    AndersonAccelerator accelerator(1);
    const auto g = [&](const Eigen::VectorXd& x) {
      return Eigen::VectorXd(slope * x + Eigen::VectorXd::Constant(1, 2.0));
    };
    const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 7.0);
    const Eigen::VectorXd first = accelerator.Propose(start, g(start));
    EXPECT_EQ(first, g(start)) << "without history the step itself";
    const Eigen::VectorXd second = accelerator.Propose(first, g(first));
    EXPECT_NEAR(second[0], 2.0 / (1.0 - slope), 1e-8 * std::abs(second[0])) << slope;
  }
}

TEST(AndersonAccelerator, SingularHistoryGivesTheStep) {
  AndersonAccelerator accelerator(3);
  const Eigen::VectorXd x = Eigen::VectorXd::Constant(4, 1.0);
  const Eigen::VectorXd g = Eigen::VectorXd::Constant(4, 2.0);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(accelerator.Propose(x, g), g);  // f does not change
}

TEST(AndersonAccelerator, DependentDifferencesStayFinite) {
  // All iterates on one line: every difference is a multiple of the others.
  Random random(2);
  const Eigen::VectorXd line = RandomVector(random, 6);
  AndersonAccelerator accelerator(5);
  double s = 10.0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::VectorXd proposal = accelerator.Propose(s * line, 0.5 * s * line);
    EXPECT_TRUE(proposal.allFinite());
    EXPECT_LT(proposal.norm(), 1.1 * std::abs(0.5 * s) * line.norm());
    s *= 0.6;
  }
}

TEST(AndersonAccelerator, ResetForgets) {
  AndersonAccelerator accelerator(2);
  const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 1.0);
  accelerator.Propose(x, 0.5 * x);
  accelerator.Propose(0.5 * x, 0.25 * x);
  accelerator.Reset();
  const Eigen::VectorXd g = Eigen::VectorXd::Constant(1, 5.0);
  EXPECT_EQ(accelerator.Propose(3.0 * x, g), g);
}

TEST(AndersonAccelerator, AcceptsAChangeOfDimension) {
  AndersonAccelerator accelerator(3);
  const Eigen::VectorXd small = Eigen::VectorXd::Constant(2, 1.0);
  accelerator.Propose(small, 0.5 * small);
  accelerator.Propose(0.5 * small, 0.3 * small);
  accelerator.Reset();
  const Eigen::VectorXd large = Eigen::VectorXd::Constant(6, 1.0);
  EXPECT_EQ(accelerator.Propose(large, 0.5 * large), 0.5 * large);
}

TEST(AndersonAccelerator, WindowIsKept) {
  // With window 1 a problem of dimension 3 is not solved in 4 steps, with window 3 it is.
  Random random(3);
  Eigen::MatrixXd a = Eigen::Vector3d(0.9, 0.5, -0.7).asDiagonal();
  const Eigen::VectorXd b = RandomVector(random, 3);
  const Eigen::VectorXd fixed_point = (Eigen::MatrixXd::Identity(3, 3) - a).partialPivLu().solve(b);
  const auto error = [&](int window) {
    AndersonAccelerator accelerator(window);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(3);
    for (int step = 0; step < 4; ++step) x = accelerator.Propose(x, a * x + b);
    return (x - fixed_point).norm();
  };
  EXPECT_LT(error(3), 1e-8);
  EXPECT_GT(error(1), 1e-4);
}

}  // namespace
}  // namespace backsight
