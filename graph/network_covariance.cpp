#include "graph/network_covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numbers>

#include "graph/pose_observations.h"

namespace backsight {
namespace {

/// Gauss-Newton matrix of the weighted links, six rows per station.
Eigen::MatrixXd Information(std::span<const PoseGraphLink> links,
                            const std::vector<double>& weights,
                            std::span<const RigidTransform> poses) {
  const auto size = static_cast<Eigen::Index>(6 * poses.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (weights[l] <= 0.0) continue;
    const PoseGraphLink& link = links[l];
    const RigidTransform& source = poses[static_cast<std::size_t>(link.source)];
    const RigidTransform& target = poses[static_cast<std::size_t>(link.target)];
    const Matrix6d jacobian =
        LocalDifferenceJacobian(LinkResidual(link, source, target)) * Adjoint(target.Inverse());
    const Matrix6d block = weights[l] * jacobian.transpose() * link.information * jacobian;
    AddRelative(6 * link.source, 6 * link.target, block, &matrix);
  }
  return matrix;
}

/// Inverse of a positive definite matrix by blocks of columns, leaving out what is zero in the
/// triangular factor: less than half of the work of solving for the identity.
void InvertInPlace(Eigen::MatrixXd* matrix) {
  constexpr Eigen::Index kBlock = 96;
  const Eigen::Index size = matrix->rows();
  Eigen::MatrixXd root = Eigen::MatrixXd::Identity(size, size);
  {
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(*matrix);
    for (Eigen::Index k = 0; k < size; k += kBlock) {
      const Eigen::Index width = std::min(kBlock, size - k);
      auto columns = root.block(k, k, size - k, width);
      matrix->bottomRightCorner(size - k, size - k)
          .triangularView<Eigen::Lower>()
          .solveInPlace(columns);
    }
  }
  matrix->setZero();
  for (Eigen::Index k = 0; k < size; k += kBlock) {
    const Eigen::Index width = std::min(kBlock, size - k);
    const auto rows = root.block(k, 0, width, k + width);
    matrix->topLeftCorner(k + width, k + width)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(rows.transpose());
  }
  matrix->triangularView<Eigen::StrictlyUpper>() = matrix->transpose();
}

/// Rows that turn a pose's xi into the station's own turn (times `lever`) and shift.
Matrix6d AtStation(const RigidTransform& pose, double lever) {
  Matrix6d carry = Matrix6d::Zero();
  carry.topLeftCorner<3, 3>().diagonal().setConstant(lever);
  carry.bottomLeftCorner<3, 3>() = -Skew(pose.translation);
  carry.bottomRightCorner<3, 3>().setIdentity();
  return carry;
}

double MedianLength(std::span<const PoseGraphLink> links) {
  std::vector<double> lengths;
  for (const PoseGraphLink& link : links) {
    lengths.push_back(link.target_from_source.translation.norm());
  }
  if (lengths.empty()) return 1.0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return std::max(*middle, 1.0);
}

}  // namespace

Eigen::MatrixXd JointCovariance(std::span<const PoseGraphLink> links,
                                const std::vector<double>& weights, const std::vector<char>& fixed,
                                std::span<const RigidTransform> poses) {
  Eigen::MatrixXd matrix = Information(links, weights, poses);
  const auto hold = [&](bool identity) {
    for (std::size_t s = 0; s < fixed.size(); ++s) {
      if (fixed[s] == 0) continue;
      const auto i = static_cast<Eigen::Index>(6 * s);
      matrix.middleRows(i, 6).setZero();
      matrix.middleCols(i, 6).setZero();
      if (identity) matrix.block<6, 6>(i, i).setIdentity();
    }
  };
  hold(true);
  // Rows and columns scaled to ones on the diagonal: radians and metres differ by powers of ten.
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  matrix = (scale.asDiagonal() * matrix * scale.asDiagonal()).eval();
  // A trace on the diagonal, far below what any network leaves there, keeps the factor real where a
  // direction is as good as unknown.
  matrix.diagonal().array() += 1e-12;
  InvertInPlace(&matrix);
  matrix = (scale.asDiagonal() * matrix * scale.asDiagonal()).eval();
  hold(false);
  return matrix;
}

Eigen::MatrixXd InFrame(const RigidTransform& to_frame, const Eigen::MatrixXd& joint) {
  const Matrix6d adjoint = Adjoint(to_frame);
  Eigen::MatrixXd moved(joint.rows(), joint.cols());
  for (Eigen::Index i = 0; i < joint.rows(); i += 6) {
    for (Eigen::Index j = 0; j < joint.cols(); j += 6) {
      moved.block<6, 6>(i, j) = adjoint * joint.block<6, 6>(i, j) * adjoint.transpose();
    }
  }
  return moved;
}

Matrix6d RelativeCovariance(const Eigen::MatrixXd& joint, int source, int target,
                            const RigidTransform& survey_from_target) {
  const Eigen::Index s = 6 * source;
  const Eigen::Index t = 6 * target;
  const Matrix6d difference = joint.block<6, 6>(s, s) + joint.block<6, 6>(t, t) -
                              joint.block<6, 6>(s, t) - joint.block<6, 6>(t, s);
  const Matrix6d adjoint = Adjoint(survey_from_target.Inverse());
  return adjoint * difference * adjoint.transpose();
}

WeakestDirection FindWeakestDirection(const Eigen::MatrixXd& joint,
                                      std::span<const PoseGraphLink> links,
                                      std::span<const RigidTransform> poses) {
  WeakestDirection weakest;
  weakest.lever_m = MedianLength(links);
  const auto stations = static_cast<Eigen::Index>(poses.size());
  if (stations == 0 || joint.diagonal().maxCoeff() <= 0.0) return weakest;
  const auto carry = [&](Eigen::Index s) {
    return AtStation(poses[static_cast<std::size_t>(s)], weakest.lever_m);
  };
  // Begins with uneven entries, lest the start be orthogonal to the direction sought.
  Eigen::VectorXd direction(6 * stations);
  for (Eigen::Index k = 0; k < direction.size(); ++k) {
    direction[k] = 1.0 + 0.37 * static_cast<double>(k % 7);
  }
  direction.normalize();
  double variance = 0.0;
  constexpr int kMaxIterations = 300;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::VectorXd in_poses(direction.size());
    for (Eigen::Index s = 0; s < stations; ++s) {
      in_poses.segment<6>(6 * s) = carry(s).transpose() * direction.segment<6>(6 * s);
    }
    Eigen::VectorXd next = joint.selfadjointView<Eigen::Lower>() * in_poses;
    for (Eigen::Index s = 0; s < stations; ++s) {
      next.segment<6>(6 * s) = carry(s) * next.segment<6>(6 * s).eval();
    }
    const double before = variance;
    variance = next.norm();
    if (variance <= 0.0) return weakest;
    direction = next / variance;
    if (std::abs(variance - before) <= 1e-9 * variance) break;
  }
  weakest.sigma_m = std::sqrt(variance);
  for (Eigen::Index s = 0; s < stations; ++s) {
    const Vector6d own = weakest.sigma_m * direction.segment<6>(6 * s);
    if (own.tail<3>().norm() <= weakest.station_m) continue;
    weakest.station = static_cast<int>(s);
    weakest.station_m = own.tail<3>().norm();
    weakest.station_deg = own.head<3>().norm() / weakest.lever_m * 180.0 / std::numbers::pi;
    weakest.axis = own.tail<3>().normalized();
  }
  return weakest;
}

}  // namespace backsight
