#include "graph/planar_cost.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace backsight {
namespace {

/// All observations of a plane at the current poses, relative to their joint centroid, so that no
/// coordinate is larger than the plane.
struct PlaneState {
  std::vector<PointCluster> parts;  // means relative to `center`
  Eigen::Vector3d center;           // world
  double count = 0.0;
  Eigen::Vector3d eigenvalues;  // ascending, m^2
  Eigen::Matrix3d axes;         // columns: normal, then the two in-plane axes
};

PlaneState Evaluate(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  PlaneState state;
  PointCluster joint;
  state.parts.reserve(plane.observations.size());
  for (const PlaneObservation& o : plane.observations) {
    const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
    state.parts.push_back(Transformed(pose.rotation, pose.translation, o.cluster));
    joint += state.parts.back();
  }
  state.center = joint.mean;
  state.count = joint.count;
  for (PointCluster& part : state.parts) part.mean -= joint.mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(joint.Covariance());
  state.eigenvalues = solver.eigenvalues().cwiseMax(0.0);
  state.axes = solver.eigenvectors();
  return state;
}

/// Turns a derivative with respect to a motion about `center` into one about the world's origin.
Vector6d AboutOrigin(const Eigen::Vector3d& rotation_part, const Eigen::Vector3d& translation_part,
                     const Eigen::Vector3d& center) {
  Vector6d derivative;
  derivative << rotation_part + center.cross(translation_part), translation_part;
  return derivative;
}

/// Second derivative of n * (point-plane distance)^2 sums of one station with the plane held:
/// sum over its points of a a^T with a = [p x u; u], p in the world.
Matrix6d HeldPlaneMatrix(const PointCluster& part, const Eigen::Vector3d& u,
                         const Eigen::Vector3d& center) {
  const Eigen::Matrix3d second = part.scatter + part.count * part.mean * part.mean.transpose();
  const Eigen::Vector3d first = part.count * part.mean;
  const Eigen::Matrix3d cross = Skew(u);
  Matrix6d local;
  local.topLeftCorner<3, 3>() = cross * second * cross.transpose();
  local.topRightCorner<3, 3>() = first.cross(u) * u.transpose();
  local.bottomLeftCorner<3, 3>() = local.topRightCorner<3, 3>().transpose();
  local.bottomRightCorner<3, 3>() = part.count * u * u.transpose();
  Matrix6d shift = Matrix6d::Identity();
  shift.bottomLeftCorner<3, 3>() = -Skew(center);
  return shift.transpose() * local * shift;
}

/// Adds one plane. Symbols as in docs/stages/fine_registration.md, with the joint centroid as
/// origin.
void AddPlane(const WeightedPlane& plane, std::span<const RigidTransform> poses,
              NormalEquations* system) {
  const PlaneState state = Evaluate(plane, poses);
  const Eigen::Vector3d u = state.axes.col(0);
  const double n = state.count;
  const double scale = 2.0 * plane.weight / n;
  system->cost += plane.weight * state.eigenvalues[0];

  const std::size_t parts = state.parts.size();
  std::vector<Vector6d> b(parts);                 // coupling through the plane's offset
  std::vector<std::array<Vector6d, 2>> w(parts);  // coupling through the plane's normal
  for (std::size_t j = 0; j < parts; ++j) {
    const PointCluster& part = state.parts[j];
    const Eigen::Matrix3d moment = part.scatter + part.count * part.mean * part.mean.transpose();
    const Eigen::Vector3d v = part.count * part.mean;
    b[j] = AboutOrigin(v.cross(u), part.count * u, state.center);
    for (int m = 0; m < 2; ++m) {
      const Eigen::Vector3d in_plane = state.axes.col(m + 1);
      w[j][static_cast<std::size_t>(m)] =
          AboutOrigin((moment * in_plane).cross(u), v.dot(in_plane) * u, state.center);
    }
    const Eigen::Index row = 6 * plane.observations[j].station;
    const Eigen::Vector3d s = moment * u;
    system->gradient.segment<6>(row) += scale * AboutOrigin(s.cross(u), v.dot(u) * u, state.center);
    system->matrix.block<6, 6>(row, row) += scale * HeldPlaneMatrix(part, u, state.center);
  }
  constexpr double kSmallestWidth = 1e-12;  // m^2
  for (std::size_t i = 0; i < parts; ++i) {
    for (std::size_t j = 0; j < parts; ++j) {
      Matrix6d coupling = b[i] * b[j].transpose() / n;
      for (std::size_t m = 0; m < 2; ++m) {
        const double width =
            std::max(state.eigenvalues[static_cast<Eigen::Index>(m) + 1], kSmallestWidth);
        coupling += w[i][m] * w[j][m].transpose() / (n * width);
      }
      system->matrix.block<6, 6>(6 * plane.observations[i].station,
                                 6 * plane.observations[j].station) -= scale * coupling;
    }
  }
}

double PriorCost(const PosePrior& prior, std::span<const RigidTransform> poses) {
  const Vector6d r =
      LocalDifference(poses[static_cast<std::size_t>(prior.station)], prior.expected);
  return 0.5 * r.dot(prior.information * r);
}

void AddPrior(const PosePrior& prior, std::span<const RigidTransform> poses,
              NormalEquations* system) {
  const Vector6d r =
      LocalDifference(poses[static_cast<std::size_t>(prior.station)], prior.expected);
  const Matrix6d jacobian = LocalDifferenceJacobian(r);
  const Eigen::Index row = 6 * prior.station;
  system->cost += 0.5 * r.dot(prior.information * r);
  system->gradient.segment<6>(row) += jacobian.transpose() * prior.information * r;
  system->matrix.block<6, 6>(row, row) += jacobian.transpose() * prior.information * jacobian;
}

}  // namespace

std::vector<double> PlaneThicknesses(std::span<const WeightedPlane> planes,
                                     std::span<const RigidTransform> poses) {
  std::vector<double> thicknesses;
  thicknesses.reserve(planes.size());
  for (const WeightedPlane& plane : planes) {
    thicknesses.push_back(Evaluate(plane, poses).eigenvalues[0]);
  }
  return thicknesses;
}

double PlanarCost(std::span<const WeightedPlane> planes, std::span<const PosePrior> priors,
                  std::span<const RigidTransform> poses) {
  double cost = 0.0;
  for (const WeightedPlane& plane : planes) {
    cost += plane.weight * Evaluate(plane, poses).eigenvalues[0];
  }
  for (const PosePrior& prior : priors) cost += PriorCost(prior, poses);
  return cost;
}

NormalEquations AssembleNormalEquations(std::span<const WeightedPlane> planes,
                                        std::span<const PosePrior> priors,
                                        std::span<const RigidTransform> poses) {
  NormalEquations system;
  const auto unknowns = static_cast<Eigen::Index>(6 * poses.size());
  system.gradient = Eigen::VectorXd::Zero(unknowns);
  system.matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (const WeightedPlane& plane : planes) AddPlane(plane, poses, &system);
  for (const PosePrior& prior : priors) AddPrior(prior, poses, &system);
  return system;
}

}  // namespace backsight
