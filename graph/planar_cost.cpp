#include "graph/planar_cost.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/for_each.h"

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

constexpr std::size_t kGrain = 64;  // planes

/// Adds a run of planes: their terms side by side, then the matrix's columns side by side, station
/// by station and within a station in the order of the planes. So every entry is summed in one
/// order, and no thread needs a matrix of its own.
void AddPlanes(std::span<const WeightedPlane> planes, std::span<const RigidTransform> poses,
               const ExecutionContext* context, NormalEquations* system) {
  std::vector<PlaneTerms> terms(planes.size());
  ForEach(
      context, planes.size(),
      [&](std::size_t k) { terms[k] = ComputePlaneTerms(planes[k], poses); }, kGrain);
  struct Place {
    const PlaneTerms* plane;
    const PlaneTerms::Part* part;
  };
  std::vector<std::vector<Place>> of_station(poses.size());
  for (const PlaneTerms& plane : terms) {
    system->cost += plane.cost;
    for (const PlaneTerms::Part& part : plane.parts) {
      of_station[static_cast<std::size_t>(part.station)].push_back({&plane, &part});
    }
  }
  const auto add_column = [&](std::size_t s) {
    const auto column = static_cast<Eigen::Index>(6 * s);
    for (const Place& place : of_station[s]) {
      system->gradient.segment<6>(column) += place.part->gradient;
      system->matrix.block<6, 6>(column, column) += place.part->held;
      for (const PlaneTerms::Part& other : place.plane->parts) {
        system->matrix.block<6, 6>(6 * other.station, column).noalias() -=
            other.coupling * place.part->coupling.transpose();
      }
    }
  };
  ForEach(context, poses.size(), add_column);
}

}  // namespace

PlaneTerms ComputePlaneTerms(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  // Symbols as in docs/stages/fine_registration.md, with the joint centroid as origin.
  const PlaneState state = Evaluate(plane, poses);
  const Eigen::Vector3d u = state.axes.col(0);
  const double n = state.count;
  const double scale = 2.0 * plane.weight / n;
  constexpr double kSmallestWidth = 1e-12;  // m^2
  PlaneTerms terms;
  terms.cost = plane.weight * state.eigenvalues[0];
  terms.parts.resize(state.parts.size());
  for (std::size_t j = 0; j < state.parts.size(); ++j) {
    const PointCluster& cluster = state.parts[j];
    const Eigen::Matrix3d moment =
        cluster.scatter + cluster.count * cluster.mean * cluster.mean.transpose();
    const Eigen::Vector3d v = cluster.count * cluster.mean;
    PlaneTerms::Part& part = terms.parts[j];
    part.station = plane.observations[j].station;
    const Eigen::Vector3d s = moment * u;
    part.gradient = scale * AboutOrigin(s.cross(u), v.dot(u) * u, state.center);
    part.held = scale * HeldPlaneMatrix(cluster, u, state.center);
    part.coupling.col(0) =
        std::sqrt(scale / n) * AboutOrigin(v.cross(u), cluster.count * u, state.center);
    for (int m = 1; m < 3; ++m) {
      const Eigen::Vector3d in_plane = state.axes.col(m);
      const double width = std::max(state.eigenvalues[m], kSmallestWidth);
      part.coupling.col(m) =
          std::sqrt(scale / (n * width)) *
          AboutOrigin((moment * in_plane).cross(u), v.dot(in_plane) * u, state.center);
    }
  }
  return terms;
}

std::vector<double> PlaneThicknesses(std::span<const WeightedPlane> planes,
                                     std::span<const RigidTransform> poses,
                                     const ExecutionContext* context) {
  std::vector<double> thicknesses(planes.size());
  ForEach(
      context, planes.size(),
      [&](std::size_t k) { thicknesses[k] = Evaluate(planes[k], poses).eigenvalues[0]; }, kGrain);
  return thicknesses;
}

double PlanarCost(const PlanarProblem& problem, std::span<const RigidTransform> poses) {
  const std::vector<double> thickness = PlaneThicknesses(problem.planes, poses, problem.context);
  double cost = 0.0;
  for (std::size_t k = 0; k < thickness.size(); ++k) {
    cost += problem.planes[k].weight * thickness[k];
  }
  return cost + PoseObservationsCost(problem.observations, poses);
}

double PlanarCost(std::span<const WeightedPlane> planes, std::span<const PosePrior> priors,
                  std::span<const RigidTransform> poses) {
  return PlanarCost(PlanarProblem{planes, {priors, {}, {}}, nullptr}, poses);
}

NormalEquations AssembleNormalEquations(const PlanarProblem& problem,
                                        std::span<const RigidTransform> poses) {
  NormalEquations system;
  const auto unknowns = static_cast<Eigen::Index>(6 * poses.size());
  system.gradient = Eigen::VectorXd::Zero(unknowns);
  system.matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
  constexpr std::size_t kBatch = 8192;  // planes whose terms are in memory at a time
  for (std::size_t begin = 0; begin < problem.planes.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, problem.planes.size() - begin);
    AddPlanes(problem.planes.subspan(begin, count), poses, problem.context, &system);
  }
  AddPoseObservations(problem.observations, poses, &system);
  return system;
}

NormalEquations AssembleNormalEquations(std::span<const WeightedPlane> planes,
                                        std::span<const PosePrior> priors,
                                        std::span<const RigidTransform> poses) {
  return AssembleNormalEquations(PlanarProblem{planes, {priors, {}, {}}, nullptr}, poses);
}

}  // namespace backsight
