#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace backsight {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rigid motion in 3D. An object called `b_from_a` maps coordinates of frame a into frame b:
/// `x_b = b_from_a * x_a`, so names chain: `c_from_a = c_from_b * b_from_a`. Metres.
struct RigidTransform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  RigidTransform operator*(const RigidTransform& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  RigidTransform Inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation)};
  }
  Eigen::Matrix4d Matrix() const;
  /// Unit quaternion with w >= 0, so that equal rotations print equally.
  Eigen::Quaterniond Quaternion() const;
  /// True if every entry is finite and the rotation is orthonormal with determinant +1 within 1e-6.
  bool IsValid() const;

  /// Builds from a 4x4 matrix; the rotation part is projected to the nearest rotation (SVD).
  static RigidTransform FromMatrix(const Eigen::Matrix4d& matrix);
  static RigidTransform FromQuaternion(const Eigen::Quaterniond& rotation,
                                       const Eigen::Vector3d& translation);
};

/// Skew-symmetric matrix [v]x with [v]x w = v x w.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

/// Rotation about `phi` by |phi| radians (Rodrigues), exact through phi = 0.
Eigen::Matrix3d ExpSo3(const Eigen::Vector3d& phi);

/// Rotation vector of `rotation`, |phi| <= pi, accurate at 0 and at pi.
Eigen::Vector3d LogSo3(const Eigen::Matrix3d& rotation);

/// The nearest rotation matrix in the Frobenius norm; use after long products.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix);

/// The one retraction of Backsight: decoupled left perturbation by xi = [phi; rho] (rotation
/// first): R <- Exp(phi) R, t <- Exp(phi) t + rho. It is not the SE(3) exponential; every
/// covariance and information matrix in the program is stated in it.
RigidTransform Retract(const RigidTransform& transform, const Vector6d& xi);

/// Inverse of Retract: the xi with Retract(reference, xi) == transform.
Vector6d LocalDifference(const RigidTransform& transform, const RigidTransform& reference);

/// d Log(Exp(d) Exp(phi)) / d d at d = 0: how a left perturbation moves a rotation vector.
Eigen::Matrix3d InverseLeftJacobianSo3(const Eigen::Vector3d& phi);

/// d LocalDifference(Retract(T, d), reference) / d d at d = 0, from the value of the difference.
Matrix6d LocalDifferenceJacobian(const Vector6d& difference);

/// d (Retract(T, d) * x) / d d at d = 0, from the moved point T * x: [-[T x]x, I]. It holds for a
/// point of a scaled frame, s R x + t, as well.
Eigen::Matrix<double, 3, 6> PointJacobian(const Eigen::Vector3d& moved_point);

/// First-order effect of a change of frame on xi: if T is perturbed by xi, then A * T * B is
/// perturbed by Adjoint(A) * xi (any B). Rotation first.
Matrix6d Adjoint(const RigidTransform& transform);

/// Angle between the z axes of both frames, radians: the tilt of two levelled instruments.
double RelativeTilt(const RigidTransform& b_from_a);

/// Rotation error between two rotations in radians, accurate for small angles (atan2 form).
double RotationAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace backsight
