#include "core/rigid_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

Vector6d RandomTwist(Random& random, double angle, double length) {
  Vector6d xi;
  for (int i = 0; i < 3; ++i) {
    xi[i] = angle * random.Uniform(-1.0, 1.0);
    xi[i + 3] = length * random.Uniform(-1.0, 1.0);
  }
  return xi;
}

RigidTransform RandomTransform(Random& random) {
  return {random.Rotation(), Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal())};
}

TEST(RigidTransform, ChainsAndInverts) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const RigidTransform c_from_b = RandomTransform(random);
    const RigidTransform b_from_a = RandomTransform(random);
    const Eigen::Vector3d x_a(random.Normal(), random.Normal(), random.Normal());
    EXPECT_LT((c_from_b * (b_from_a * x_a) - (c_from_b * b_from_a) * x_a).norm(), 1e-14);
    EXPECT_LT(((b_from_a.Inverse() * (b_from_a * x_a)) - x_a).norm(), 1e-14);
  }
}

TEST(RigidTransform, LogInvertsExpUpToPi) {
  Random random(2);
  for (const double angle :
       {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.5, 2.0, 3.1, std::numbers::pi - 1e-7}) {
    const Eigen::Vector3d axis = random.Rotation().col(0);
    const Eigen::Vector3d phi = angle * axis;
    EXPECT_LT((LogSo3(ExpSo3(phi)) - phi).norm(), 1e-7 * angle + 1e-15) << angle;
  }
  const Eigen::Matrix3d half_turn = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  EXPECT_NEAR(LogSo3(half_turn).norm(), std::numbers::pi, 1e-12);
}

TEST(RigidTransform, ExpMatchesAngleAxis) {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d axis = random.Rotation().col(0);
    const double angle = random.Uniform(0.0, 3.0);
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((ExpSo3(angle * axis) - expected).norm(), 1e-12);
    EXPECT_NEAR(RotationAngle(expected, Eigen::Matrix3d::Identity()), angle, 1e-12);
  }
}

TEST(RigidTransform, LocalDifferenceInvertsRetract) {
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    const RigidTransform reference = RandomTransform(random);
    const Vector6d xi = RandomTwist(random, 1.0, 5.0);
    EXPECT_LT((LocalDifference(Retract(reference, xi), reference) - xi).norm(), 1e-12);
  }
}

TEST(RigidTransform, AdjointMovesPerturbationsThroughProducts) {
  Random random(5);
  const double h = 1e-6;
  for (int k = 0; k < 50; ++k) {
    const RigidTransform a = RandomTransform(random);
    const RigidTransform t = RandomTransform(random);
    const RigidTransform b = RandomTransform(random);
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      numeric.col(i) = (LocalDifference(a * Retract(t, step) * b, a * t * b) -
                        LocalDifference(a * Retract(t, -step) * b, a * t * b)) /
                       (2.0 * h);
    }
    EXPECT_LT((numeric - Adjoint(a)).norm(), 1e-8);
  }
}

TEST(RigidTransform, NearestRotationRepairsAndNeverMirrors) {
  Random random(6);
  const Eigen::Matrix3d rotation = random.Rotation();
  EXPECT_LT((NearestRotation(1.001 * rotation) - rotation).norm(), 1e-12);
  EXPECT_GT(NearestRotation(-rotation).determinant(), 0.0);
}

TEST(RigidTransform, SmallRotationErrorsKeepTheirDigits) {
  const Eigen::Matrix3d tiny = ExpSo3({1e-9, 0.0, 0.0});
  EXPECT_NEAR(RotationAngle(tiny, Eigen::Matrix3d::Identity()), 1e-9, 1e-15);
}

TEST(RigidTransform, InverseLeftJacobianEqualsFiniteDifferences) {
  Random random(7);
  const double h = 1e-6;
  for (const double angle : {0.0, 1e-6, 0.009, 0.011, 0.5, 2.0, 3.0}) {
    const Eigen::Vector3d phi = angle * random.Rotation().col(0);
    Eigen::Matrix3d numeric;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
      numeric.col(i) =
          (LogSo3(ExpSo3(step) * ExpSo3(phi)) - LogSo3(ExpSo3(-step) * ExpSo3(phi))) / (2.0 * h);
    }
    EXPECT_LT((numeric - InverseLeftJacobianSo3(phi)).norm(), 1e-7) << angle;
  }
}

TEST(RigidTransform, LocalDifferenceJacobianEqualsFiniteDifferences) {
  Random random(8);
  const double h = 1e-6;
  for (int k = 0; k < 50; ++k) {
    const RigidTransform reference = RandomTransform(random);
    const RigidTransform t = Retract(reference, RandomTwist(random, 1.0, 5.0));
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      numeric.col(i) = (LocalDifference(Retract(t, step), reference) -
                        LocalDifference(Retract(t, -step), reference)) /
                       (2.0 * h);
    }
    const Matrix6d analytic = LocalDifferenceJacobian(LocalDifference(t, reference));
    EXPECT_LT((numeric - analytic).norm(), 1e-7);
  }
}

TEST(RigidTransform, PointJacobianEqualsFiniteDifferences) {
  Random random(10);
  const double h = 1e-6;
  for (int k = 0; k < 50; ++k) {
    const RigidTransform t = RandomTransform(random);
    const Eigen::Vector3d x(random.Normal(), random.Normal(), random.Normal());
    Eigen::Matrix<double, 3, 6> numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      numeric.col(i) = (Retract(t, step) * x - Retract(t, -step) * x) / (2.0 * h);
    }
    EXPECT_LT((numeric - PointJacobian(t * x)).norm(), 1e-8);
  }
}

TEST(RigidTransform, MatrixAndQuaternionRoundTrip) {
  Random random(9);
  for (int k = 0; k < 50; ++k) {
    const RigidTransform t = RandomTransform(random);
    EXPECT_GE(t.Quaternion().w(), 0.0);
    const RigidTransform from_quaternion =
        RigidTransform::FromQuaternion(t.Quaternion(), t.translation);
    const RigidTransform from_matrix = RigidTransform::FromMatrix(t.Matrix());
    EXPECT_LT(LocalDifference(from_quaternion, t).norm(), 1e-14);
    EXPECT_LT(LocalDifference(from_matrix, t).norm(), 1e-14);
  }
}

TEST(RigidTransform, ValidityRefusesMirrorsScalesAndNan) {
  Random random(10);
  const RigidTransform t = RandomTransform(random);
  EXPECT_TRUE(t.IsValid());
  EXPECT_FALSE((RigidTransform{-t.rotation, t.translation}.IsValid()));
  EXPECT_FALSE((RigidTransform{1.0001 * t.rotation, t.translation}.IsValid()));
  RigidTransform nan = t;
  nan.translation.y() = std::nan("");
  EXPECT_FALSE(nan.IsValid());
}

}  // namespace
}  // namespace backsight
