#include "stages/open_translations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace backsight {
namespace {

struct Translation {
  Eigen::Matrix3d known = Eigen::Matrix3d::Zero();  ///< G
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();  ///< N
};

void AddPlane(const WeightedPlane& plane, std::span<const RigidTransform> poses,
              Translation* translation) {
  const PointCluster joint = JointCluster(plane, poses);
  double inverse_counts = 0.0;
  for (const PlaneObservation& o : plane.observations) inverse_counts += 1.0 / o.cluster.count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(joint.Covariance());
  const Eigen::Vector3d& variances = axes.eigenvalues();
  if (!(variances[1] > 0.0)) return;
  constexpr double kFloor = 0.001 * 0.001;  // m^2: no plane is better than a millimetre
  const double variance = std::max(variances[0], kFloor);
  const double of_offset = 2.0 * plane.weight / (joint.count * inverse_counts);
  const auto along = [&](int axis) -> Eigen::Matrix3d {
    return axes.eigenvectors().col(axis) * axes.eigenvectors().col(axis).transpose();
  };
  translation->known += of_offset * along(0);
  for (int axis = 1; axis < 3; ++axis) {
    translation->noise += of_offset * variance / (joint.count * variances[axis]) * along(axis);
  }
}

}  // namespace

Eigen::Matrix3Xd OpenTranslations(std::span<const WeightedPlane> planes,
                                  std::span<const RigidTransform> poses, double least_ratio) {
  Translation sums;
  for (const WeightedPlane& plane : planes) AddPlane(plane, poses, &sums);
  const Eigen::Matrix3d both = sums.known + sums.noise;  // definite: every plane adds to all axes
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> solver(sums.noise, both);
  Eigen::Matrix3Xd open(3, 0);
  for (int i = 0; i < 3; ++i) {
    const bool is_open = solver.eigenvalues()[i] * (1.0 + least_ratio) >= 1.0;
    if (!is_open) continue;
    open.conservativeResize(Eigen::NoChange, open.cols() + 1);
    open.rightCols<1>() = solver.eigenvectors().col(i).normalized();
  }
  return open;
}

RigidTransform HoldTranslations(const Eigen::Matrix3Xd& open, const Eigen::Vector3d& point,
                                const RigidTransform& start, const Matrix6d& information,
                                const RigidTransform& motion) {
  if (open.cols() == 0) return motion;
  const Eigen::Vector3d moved = motion * point;
  const Eigen::MatrixXd shift = PointJacobian(moved).transpose() * open;
  const Eigen::MatrixXd reaction = information.ldlt().solve(shift);
  const Eigen::VectorXd excess =
      (shift.transpose() * reaction).ldlt().solve(open.transpose() * (moved - start * point));
  return Retract(motion, -reaction * excess);
}

Matrix6d WithoutTranslations(const Eigen::Matrix3Xd& open, const Matrix6d& information) {
  if (open.cols() == 0) return information;
  Eigen::MatrixXd translation = Eigen::MatrixXd::Zero(6, open.cols());
  translation.bottomRows<3>() = open;
  const Eigen::MatrixXd known = information * translation;
  return information - known * (translation.transpose() * known).ldlt().solve(known.transpose());
}

}  // namespace backsight
