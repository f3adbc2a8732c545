#include "graph/pose_observations.h"

namespace backsight {
namespace {

const RigidTransform& PoseOf(int station, std::span<const RigidTransform> poses) {
  return poses[static_cast<std::size_t>(station)];
}

Vector6d Residual(const PosePrior& prior, std::span<const RigidTransform> poses) {
  return LocalDifference(PoseOf(prior.station, poses), prior.expected);
}

Vector6d Residual(const PoseGraphLink& link, std::span<const RigidTransform> poses) {
  return LinkResidual(link, PoseOf(link.source, poses), PoseOf(link.target, poses));
}

Eigen::Vector3d AxisOf(const TiltObservation& tilt, std::span<const RigidTransform> poses) {
  return PoseOf(tilt.station, poses).rotation.col(2);
}

double TiltCost(std::span<const TiltObservation> tilts, std::span<const RigidTransform> poses) {
  const Vertical vertical = EstimateVertical(tilts, poses);
  double cost = 0.0;
  for (const TiltObservation& tilt : tilts) {
    cost += 0.5 * tilt.weight() * (AxisOf(tilt, poses) - vertical.mean).squaredNorm();
  }
  return cost;
}

void Add(const PosePrior& prior, std::span<const RigidTransform> poses, NormalEquations* system) {
  const Vector6d r = Residual(prior, poses);
  const Matrix6d jacobian = LocalDifferenceJacobian(r);
  const Eigen::Index row = 6 * prior.station;
  system->cost += 0.5 * r.dot(prior.information * r);
  system->gradient.segment<6>(row) += jacobian.transpose() * prior.information * r;
  system->matrix.block<6, 6>(row, row) += jacobian.transpose() * prior.information * jacobian;
}

/// A motion of the source moves the relative pose by the adjoint of target^-1, one of the target by
/// its negative.
void Add(const PoseGraphLink& link, std::span<const RigidTransform> poses,
         NormalEquations* system) {
  const Vector6d r = Residual(link, poses);
  const Matrix6d jacobian =
      LocalDifferenceJacobian(r) * Adjoint(PoseOf(link.target, poses).Inverse());
  const Vector6d gradient = jacobian.transpose() * link.information * r;
  const Matrix6d block = jacobian.transpose() * link.information * jacobian;
  const Eigen::Index i = 6 * link.source;
  const Eigen::Index j = 6 * link.target;
  system->cost += 0.5 * r.dot(link.information * r);
  system->gradient.segment<6>(i) += gradient;
  system->gradient.segment<6>(j) -= gradient;
  AddRelative(i, j, block, &system->matrix);
}

/// A rotation phi moves an axis z by phi x z; the mean axis moves with the axes' weighted mean.
void AddTilts(std::span<const TiltObservation> tilts, std::span<const RigidTransform> poses,
              NormalEquations* system) {
  const Vertical vertical = EstimateVertical(tilts, poses);
  for (const TiltObservation& a : tilts) {
    const Eigen::Vector3d z = AxisOf(a, poses);
    const Eigen::Matrix3d cross = Skew(z);
    const Eigen::Index row = 6 * a.station;
    system->cost += 0.5 * a.weight() * (z - vertical.mean).squaredNorm();
    system->gradient.segment<3>(row) += a.weight() * z.cross(z - vertical.mean);
    system->matrix.block<3, 3>(row, row) += a.weight() * cross.transpose() * cross;
    for (const TiltObservation& b : tilts) {
      system->matrix.block<3, 3>(row, 6 * b.station) -=
          a.weight() * b.weight() / vertical.weight * cross.transpose() * Skew(AxisOf(b, poses));
    }
  }
}

}  // namespace

void AddRelative(Eigen::Index i, Eigen::Index j, const Matrix6d& information,
                 Eigen::MatrixXd* matrix) {
  matrix->block<6, 6>(i, i) += information;
  matrix->block<6, 6>(j, j) += information;
  matrix->block<6, 6>(i, j) -= information;
  matrix->block<6, 6>(j, i) -= information;
}

Vertical EstimateVertical(std::span<const TiltObservation> tilts,
                          std::span<const RigidTransform> poses) {
  Vertical vertical;
  for (const TiltObservation& tilt : tilts) {
    vertical.weight += tilt.weight();
    vertical.mean += tilt.weight() / vertical.weight * (AxisOf(tilt, poses) - vertical.mean);
  }
  return vertical;
}

double PoseObservationsCost(const PoseObservations& observations,
                            std::span<const RigidTransform> poses) {
  double cost = TiltCost(observations.tilts, poses);
  for (const PosePrior& prior : observations.priors) {
    const Vector6d r = Residual(prior, poses);
    cost += 0.5 * r.dot(prior.information * r);
  }
  for (const PoseGraphLink& link : observations.links) {
    const Vector6d r = Residual(link, poses);
    cost += 0.5 * r.dot(link.information * r);
  }
  return cost;
}

void AddPoseObservations(const PoseObservations& observations,
                         std::span<const RigidTransform> poses, NormalEquations* system) {
  for (const PosePrior& prior : observations.priors) Add(prior, poses, system);
  for (const PoseGraphLink& link : observations.links) Add(link, poses, system);
  AddTilts(observations.tilts, poses, system);
}

}  // namespace backsight
