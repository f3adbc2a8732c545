#include "graph/planar_cost.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "graph/for_each.h"
#include "graph/plane_fit.h"

namespace backsight {
namespace {

/// An observation's points at the current poses, world. A pair's target stands at the origin.
PointCluster InWorld(const PlaneObservation& o, std::span<const RigidTransform> poses) {
  const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
  const bool is_identity =
      pose.translation == Eigen::Vector3d::Zero() && pose.rotation == Eigen::Matrix3d::Identity();
  return is_identity ? o.cluster : Transformed(pose.rotation, pose.translation, o.cluster);
}

/// Calls `body(k, joint, fit)` for every plane, fitted several at a time.
template <class Body>
void FitJointly(std::span<const WeightedPlane> planes, std::span<const RigidTransform> poses,
                const ExecutionContext* context, bool normals, Body body) {
  constexpr std::size_t kTogether = 8;
  const auto fit = [&](std::size_t chunk) {
    const std::size_t begin = chunk * kTogether;
    const std::size_t count = std::min(kTogether, planes.size() - begin);
    std::array<PointCluster, kTogether> joint;
    std::array<PlaneFit, kTogether> fits;
    for (std::size_t i = 0; i < count; ++i) joint[i] = JointCluster(planes[begin + i], poses);
    FitPlanes(std::span(joint).first(count), normals, fits);
    for (std::size_t i = 0; i < count; ++i) body(begin + i, joint[i], fits[i]);
  };
  constexpr std::size_t kGrain = 8;  // chunks
  ForEach(context, (planes.size() + kTogether - 1) / kTogether, fit, kGrain);
}

/// Turns a derivative with respect to a motion about `center` into one about the world's origin.
Vector6d AboutOrigin(const Eigen::Vector3d& rotation_part, const Eigen::Vector3d& translation_part,
                     const Eigen::Vector3d& center) {
  Vector6d derivative;
  derivative << rotation_part + center.cross(translation_part), translation_part;
  return derivative;
}

/// Second derivative of n * (point-plane distance)^2 sums of one station with the plane held:
/// sum over its points of a a^T with a = [p x u; u], p in the world. `moment`: second moment of the
/// points about `center`, `first` the sum of their offsets from it.
Matrix6d HeldPlaneMatrix(const Eigen::Matrix3d& moment, const Eigen::Vector3d& first, double count,
                         const Eigen::Vector3d& u, const Eigen::Vector3d& center) {
  const Eigen::Matrix3d cross = Skew(u);
  const Eigen::Vector3d lever = center.cross(u);
  const Eigen::Vector3d turn = first.cross(u);
  Matrix6d held;
  held.topLeftCorner<3, 3>() = cross * moment * cross.transpose() + turn * lever.transpose() +
                               lever * (turn + count * lever).transpose();
  held.topRightCorner<3, 3>() = (turn + count * lever) * u.transpose();
  held.bottomLeftCorner<3, 3>() = held.topRightCorner<3, 3>().transpose();
  held.bottomRightCorner<3, 3>() = count * u * u.transpose();
  return held;
}

/// Columns t1, t2 in the plane with t1 t1^T + t2 t2^T the inverse of the covariance there: the sum
/// over both in-plane eigenvectors of v v^T / lambda, whatever their directions.
Eigen::Matrix<double, 3, 2> InverseWidths(const Eigen::Matrix3d& covariance,
                                          const Eigen::Vector3d& normal) {
  constexpr double kSmallestWidth = 1e-12;  // m^2
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = normal.unitOrthogonal();
  axes.col(1) = normal.cross(axes.col(0));
  const Eigen::Vector3d along = covariance * axes.col(0);
  const double first = std::max(axes.col(0).dot(along), kSmallestWidth);
  const double slope = axes.col(1).dot(along) / first;
  const double second =
      std::max(axes.col(1).dot(covariance * axes.col(1)) - slope * slope * first, kSmallestWidth);
  axes.col(1) = (axes.col(1) - slope * axes.col(0)) / std::sqrt(second);
  axes.col(0) /= std::sqrt(first);
  return axes;
}

/// What turning a station's points in circles adds to the second derivative of the sum of their
/// offsets from the plane, each weighted by itself. `pulled`: sum over its points of offset * p.
Eigen::Matrix3d TurningPart(const Eigen::Vector3d& u, const Eigen::Vector3d& pulled) {
  return 0.5 * (u * pulled.transpose() + pulled * u.transpose()) -
         u.dot(pulled) * Eigen::Matrix3d::Identity();
}

/// The plane's terms from the cluster of all its points, and their fit; but for the parts of
/// `unneeded_station`.
void SetTerms(const WeightedPlane& plane, std::span<const RigidTransform> poses,
              int unneeded_station, PlaneCurvature curvature, const PointCluster& joint,
              const PlaneFit& fit, PlaneTerms* terms) {
  // Symbols as in docs/stages/fine_registration.md, with the joint centroid as origin.
  const Eigen::Vector3d& u = fit.normal;
  const double n = joint.count;
  const double scale = 2.0 * plane.weight / n;
  const bool exact = curvature == PlaneCurvature::kExact;
  const double stiffening = exact ? fit.eigenvalues[0] : 0.0;
  const Eigen::Matrix<double, 3, 2> in_plane =
      InverseWidths(joint.Covariance() - stiffening * Eigen::Matrix3d::Identity(), u);
  terms->cost = plane.weight * std::max(fit.eigenvalues[0], 0.0);
  terms->parts.resize(plane.observations.size());
  for (std::size_t j = 0; j < terms->parts.size(); ++j) {
    const PlaneObservation& o = plane.observations[j];
    terms->parts[j].station = o.station;
    if (o.station == unneeded_station) continue;
    const PointCluster cluster = InWorld(o, poses);
    const Eigen::Vector3d offset = cluster.mean - joint.mean;
    const Eigen::Vector3d v = cluster.count * offset;
    const Eigen::Matrix3d moment = cluster.scatter + v * offset.transpose();
    const Eigen::Vector3d along = moment * u;
    PlaneTerms::Part& part = terms->parts[j];
    part.gradient = scale * AboutOrigin(along.cross(u), v.dot(u) * u, joint.mean);
    part.held = scale * HeldPlaneMatrix(moment, v, cluster.count, u, joint.mean);
    if (exact) {
      part.held.topLeftCorner<3, 3>() += scale * TurningPart(u, along + v.dot(u) * joint.mean);
    }
    const double root = std::sqrt(scale / n);
    part.coupling.col(0) = root * AboutOrigin(v.cross(u), cluster.count * u, joint.mean);
    for (int m = 0; m < 2; ++m) {
      const Eigen::Vector3d t = in_plane.col(m);
      part.coupling.col(m + 1) =
          root * AboutOrigin((moment * t).cross(u), v.dot(t) * u, joint.mean);
      if (exact) {
        part.coupling.col(m + 1) += root * AboutOrigin(along.cross(t), v.dot(u) * t, joint.mean);
      }
    }
  }
}

}  // namespace

PointCluster JointCluster(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  PointCluster joint;
  for (const PlaneObservation& o : plane.observations) joint += InWorld(o, poses);
  return joint;
}

PlaneTerms ComputePlaneTerms(const WeightedPlane& plane, std::span<const RigidTransform> poses,
                             PlaneCurvature curvature) {
  const PointCluster joint = JointCluster(plane, poses);
  PlaneFit fit;
  FitPlanes(std::span(&joint, 1), /*normals=*/true, std::span(&fit, 1));
  PlaneTerms terms;
  SetTerms(plane, poses, /*unneeded_station=*/-1, curvature, joint, fit, &terms);
  return terms;
}

std::vector<double> PlaneThicknesses(std::span<const WeightedPlane> planes,
                                     std::span<const RigidTransform> poses,
                                     const ExecutionContext* context) {
  std::vector<double> thicknesses(planes.size());
  FitJointly(planes, poses, context, /*normals=*/false,
             [&](std::size_t k, const PointCluster& /*joint*/, const PlaneFit& fit) {
               thicknesses[k] = std::max(fit.eigenvalues[0], 0.0);
             });
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

/// Adds a run of planes: their terms side by side, then the matrix's columns side by side, station
/// by station and within a station in the order of the planes. So every entry is summed in one
/// order, and no thread needs a matrix of its own.
void NormalEquationsAssembler::AddPlanes(const PlanarProblem& problem,
                                         std::span<const WeightedPlane> planes,
                                         std::span<const RigidTransform> poses) {
  const int unneeded = problem.unneeded_station;
  terms_.resize(planes.size());
  FitJointly(planes, poses, problem.context, /*normals=*/true,
             [&](std::size_t k, const PointCluster& joint, const PlaneFit& fit) {
               SetTerms(planes[k], poses, unneeded, problem.curvature, joint, fit, &terms_[k]);
             });
  of_station_.resize(poses.size());
  for (std::vector<Place>& places : of_station_) places.clear();
  for (const PlaneTerms& plane : terms_) {
    system_.cost += plane.cost;
    for (const PlaneTerms::Part& part : plane.parts) {
      if (part.station == unneeded) continue;
      of_station_[static_cast<std::size_t>(part.station)].push_back({&plane, &part});
    }
  }
  const auto add_column = [&](std::size_t s) {
    const auto column = static_cast<Eigen::Index>(6 * s);
    for (const Place& place : of_station_[s]) {
      system_.gradient.segment<6>(column) += place.part->gradient;
      system_.matrix.block<6, 6>(column, column) += place.part->held;
      for (const PlaneTerms::Part& other : place.plane->parts) {
        if (other.station == unneeded) continue;
        system_.matrix.block<6, 6>(6 * other.station, column).noalias() -=
            other.coupling * place.part->coupling.transpose();
      }
    }
  };
  ForEach(problem.context, poses.size(), add_column);
}

const NormalEquations& NormalEquationsAssembler::Assemble(const PlanarProblem& problem,
                                                          std::span<const RigidTransform> poses) {
  const auto unknowns = static_cast<Eigen::Index>(6 * poses.size());
  system_.cost = 0.0;
  system_.gradient.setZero(unknowns);
  system_.matrix.setZero(unknowns, unknowns);
  constexpr std::size_t kBatch = 2048;  // planes whose terms are in memory at a time
  for (std::size_t begin = 0; begin < problem.planes.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, problem.planes.size() - begin);
    AddPlanes(problem, problem.planes.subspan(begin, count), poses);
  }
  AddPoseObservations(problem.observations, poses, &system_);
  return system_;
}

NormalEquations AssembleNormalEquations(const PlanarProblem& problem,
                                        std::span<const RigidTransform> poses) {
  return NormalEquationsAssembler().Assemble(problem, poses);
}

NormalEquations AssembleNormalEquations(std::span<const WeightedPlane> planes,
                                        std::span<const PosePrior> priors,
                                        std::span<const RigidTransform> poses) {
  return AssembleNormalEquations(PlanarProblem{planes, {priors, {}, {}}, nullptr}, poses);
}

}  // namespace backsight
