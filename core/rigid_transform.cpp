#include "core/rigid_transform.h"

#include <Eigen/SVD>
#include <cmath>

namespace backsight {

Eigen::Matrix4d RigidTransform::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation;
  matrix.topRightCorner<3, 1>() = translation;
  return matrix;
}

Eigen::Quaterniond RigidTransform::Quaternion() const {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q;
}

bool RigidTransform::IsValid() const {
  if (!rotation.allFinite() || !translation.allFinite()) return false;
  const double orthonormality_error =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  return orthonormality_error < 1e-6 && rotation.determinant() > 0.0;
}

RigidTransform RigidTransform::FromMatrix(const Eigen::Matrix4d& matrix) {
  return {NearestRotation(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>()};
}

RigidTransform RigidTransform::FromQuaternion(const Eigen::Quaterniond& rotation,
                                              const Eigen::Vector3d& translation) {
  return {rotation.normalized().toRotationMatrix(), translation};
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Matrix3d ExpSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d k = Skew(phi);
  // sin(a)/a and (1 - cos(a))/a^2 by their series where the quotients lose digits.
  double a = 1.0 - angle * angle / 6.0;
  double b = 0.5 - angle * angle / 24.0;
  if (angle > 1e-4) {
    a = std::sin(angle) / angle;
    b = (1.0 - std::cos(angle)) / (angle * angle);
  }
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

Eigen::Vector3d LogSo3(const Eigen::Matrix3d& rotation) {
  // Through the quaternion: well conditioned at 0 and at pi.
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  if (s < 1e-12) return 2.0 * q.vec();
  return (2.0 * std::atan2(s, q.w()) / s) * q.vec();
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  signs.z() = signs.z() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

RigidTransform Retract(const RigidTransform& transform, const Vector6d& xi) {
  const Eigen::Matrix3d delta = ExpSo3(xi.head<3>());
  return {delta * transform.rotation, delta * transform.translation + xi.tail<3>()};
}

Vector6d LocalDifference(const RigidTransform& transform, const RigidTransform& reference) {
  const Eigen::Matrix3d delta = transform.rotation * reference.rotation.transpose();
  Vector6d xi;
  xi.head<3>() = LogSo3(delta);
  xi.tail<3>() = transform.translation - delta * reference.translation;
  return xi;
}

Eigen::Matrix3d InverseLeftJacobianSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d k = Skew(phi);
  // 1/a^2 - (1 + cos a) / (2 a sin a), by its series where it is 0/0.
  double c = 1.0 / 12.0 + angle * angle / 720.0;
  if (angle > 1e-2) {
    c = 1.0 / (angle * angle) - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  }
  return Eigen::Matrix3d::Identity() - 0.5 * k + c * k * k;
}

Matrix6d LocalDifferenceJacobian(const Vector6d& difference) {
  Matrix6d jacobian = Matrix6d::Identity();
  jacobian.topLeftCorner<3, 3>() = InverseLeftJacobianSo3(difference.head<3>());
  jacobian.bottomLeftCorner<3, 3>() = -Skew(difference.tail<3>());
  return jacobian;
}

Eigen::Matrix<double, 3, 6> PointJacobian(const Eigen::Vector3d& moved_point) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -Skew(moved_point), Eigen::Matrix3d::Identity();
  return jacobian;
}

Matrix6d Adjoint(const RigidTransform& transform) {
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = transform.rotation;
  adjoint.bottomRightCorner<3, 3>() = transform.rotation;
  adjoint.bottomLeftCorner<3, 3>() = Skew(transform.translation) * transform.rotation;
  return adjoint;
}

double RelativeTilt(const RigidTransform& b_from_a) {
  const Eigen::Vector3d up = b_from_a.rotation.col(2);
  return std::atan2(std::hypot(up.x(), up.y()), up.z());
}

double RotationAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d d = a * b.transpose();
  const Eigen::Vector3d vee(d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1));
  return std::atan2(vee.norm() / 2.0, (d.trace() - 1.0) / 2.0);
}

}  // namespace backsight
