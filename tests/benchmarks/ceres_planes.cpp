#include "tests/benchmarks/ceres_planes.h"

#include <ceres/ceres.h>
#include <ceres/manifold.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "graph/plane_fit.h"

namespace backsight {
namespace {

struct PoseBlock {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
};

struct PlaneBlock {
  Eigen::Vector4d plane;   // unit normal, and the offset along it from the centre
  Eigen::Vector3d center;  // fixed
};
using PlaneManifold = ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>>;

/// sqrt(2 weight share) times the distance of the cluster's mean from the plane and the standard
/// deviations of its points along the normal.
class ObservationCost {
 public:
  ObservationCost(const PointCluster& cluster, double factor, const Eigen::Vector3d& center)
      : mean_(cluster.mean), center_(center), factor_(factor) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(cluster.Covariance());
    root_ =
        axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * axes.eigenvectors().transpose();
  }

  template <typename T>
  bool operator()(const T* rotation, const T* translation, const T* plane, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
    const Eigen::Map<const Vector> t(translation);
    const Eigen::Map<const Vector> n(plane);
    const Vector moved = q * mean_.template cast<T>() + t - center_.template cast<T>();
    residual[0] = T(factor_) * (n.dot(moved) - plane[3]);
    Eigen::Map<Vector> spread(residual + 1);
    spread = T(factor_) * (root_.template cast<T>() * (q.conjugate() * Vector(n)));
    return true;
  }

 private:
  Eigen::Vector3d mean_;
  Eigen::Vector3d center_;
  Eigen::Matrix3d root_;
  double factor_;
};

PointCluster Whole(const WeightedPlane& plane, std::span<const RigidTransform> poses) {
  PointCluster all;
  for (const PlaneObservation& o : plane.observations) {
    const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
    all += Transformed(pose.rotation, pose.translation, o.cluster);
  }
  return all;
}

/// A plane's unknowns, with all that was observed of it, for Ceres to eliminate first.
void AddPlane(const WeightedPlane& plane, const PointCluster& all, std::vector<PoseBlock>* poses,
              PlaneBlock* block, ceres::Problem* problem, ceres::ParameterBlockOrdering* order) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(all.Covariance());
  block->plane << axes.eigenvectors().col(0), 0.0;
  block->center = all.mean;
  for (const PlaneObservation& o : plane.observations) {
    const double factor = std::sqrt(2.0 * plane.weight * o.cluster.count / all.count);
    PoseBlock& pose = (*poses)[static_cast<std::size_t>(o.station)];
    problem->AddResidualBlock(new ceres::AutoDiffCostFunction<ObservationCost, 4, 4, 3, 4>(
                                  new ObservationCost(o.cluster, factor, block->center)),
                              nullptr, pose.rotation.coeffs().data(), pose.translation.data(),
                              block->plane.data());
  }
  problem->SetManifold(block->plane.data(), new PlaneManifold());
  order->AddElementToGroup(block->plane.data(), 0);
}

}  // namespace

CeresPlanesResult AdjustPlanesWithCeres(std::span<const WeightedPlane> planes,
                                        std::span<const RigidTransform> start, int fixed_station,
                                        double relative_decrease, int threads) {
  std::vector<PoseBlock> poses;
  for (const RigidTransform& pose : start) {
    poses.push_back({Eigen::Quaterniond(pose.rotation), pose.translation});
  }
  std::vector<PlaneBlock> blocks(planes.size());
  ceres::Problem problem;
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t p = 0; p < planes.size(); ++p) {
    AddPlane(planes[p], Whole(planes[p], start), &poses, &blocks[p], &problem, order.get());
  }
  for (std::size_t s = 0; s < poses.size(); ++s) {
    double* const rotation = poses[s].rotation.coeffs().data();
    double* const translation = poses[s].translation.data();
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetManifold(rotation, new ceres::EigenQuaternionManifold());
    order->AddElementToGroup(rotation, 1);
    order->AddElementToGroup(translation, 1);
    if (static_cast<int>(s) != fixed_station) continue;
    problem.SetParameterBlockConstant(rotation);
    problem.SetParameterBlockConstant(translation);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.linear_solver_ordering = order;
  options.function_tolerance = relative_decrease;
  options.num_threads = threads;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  CeresPlanesResult result;
  for (const PoseBlock& pose : poses) {
    result.poses.push_back({pose.rotation.normalized().toRotationMatrix(), pose.translation});
  }
  result.final_cost = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  return result;
}

}  // namespace backsight
