#include "stages/surface_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/neighbors.h"

namespace backsight {
namespace {

constexpr double kReach = 2.0;                       // voxels, between matched means
const double kLargestAngleCosine = std::sqrt(0.75);  // 30 deg between matched normals
constexpr int kMaxIterations = 10;
constexpr int kFewestMatches = 100;

std::vector<Eigen::Vector3d> Means(const StationModel& model) {
  std::vector<Eigen::Vector3d> means;
  means.reserve(model.leaves.size());
  for (const VoxelLeaf& leaf : model.leaves) means.push_back(leaf.cluster.mean);
  return means;
}

/// Normal equations of one iteration with nearest neighbours under the current motion.
class Iteration {
 public:
  Iteration(double along_sigma_m, double across_sigma_m)
      : along_(along_sigma_m * along_sigma_m), across_(across_sigma_m * across_sigma_m) {}

  void Add(const Eigen::Vector3d& moved, const Eigen::Vector3d& moved_normal,
           const Eigen::Vector3d& fixed, const Eigen::Vector3d& fixed_normal) {
    const Eigen::Matrix3d covariance =
        2.0 * along_ * Eigen::Matrix3d::Identity() -
        (along_ - across_) *
            (moved_normal * moved_normal.transpose() + fixed_normal * fixed_normal.transpose());
    const Eigen::Matrix3d weight = covariance.inverse();
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << -Skew(moved), Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 6, 3> weighted = jacobian.transpose() * weight;
    matrix_ += weighted * jacobian;
    gradient_ += weighted * (moved - fixed);
    ++matches_;
  }

  Vector6d Solve(const Matrix6d& prior, const Vector6d& prior_residual) const {
    const Matrix6d matrix = matrix_ + prior;
    return -matrix.ldlt().solve(gradient_ + prior * prior_residual);
  }
  int matches() const { return matches_; }

 private:
  double along_, across_;
  Matrix6d matrix_ = Matrix6d::Zero();
  Vector6d gradient_ = Vector6d::Zero();
  int matches_ = 0;
};

}  // namespace

SurfaceRefinement RefineOnSurfaces(const Surface& source, const Surface& target,
                                   const RigidTransform& start, const Matrix6d& prior,
                                   double normal_sigma_m) {
  SurfaceRefinement result;
  result.target_from_source = start;
  const double l = target.model.resolution_m();
  const std::vector<Eigen::Vector3d> fixed = Means(target.model);
  const NeighborSearch search(fixed);
  constexpr std::size_t kSample = 20000;
  const std::size_t stride = std::max<std::size_t>(1, source.model.leaves.size() / kSample);
  while (result.iterations < kMaxIterations) {
    ++result.iterations;
    const RigidTransform& motion = result.target_from_source;
    Iteration iteration(l, normal_sigma_m);
    for (std::size_t i = 0; i < source.model.leaves.size(); i += stride) {
      if (!source.normals[i].allFinite()) continue;
      const Eigen::Vector3d moved = motion * source.model.leaves[i].cluster.mean;
      const auto nearest = search.Nearest(moved, 1);
      if (nearest.empty() || nearest[0].distance_m > kReach * l) continue;
      const Eigen::Vector3f& other = target.normals[nearest[0].index];
      if (!other.allFinite()) continue;
      const Eigen::Vector3d moved_normal = motion.rotation * source.normals[i].cast<double>();
      const Eigen::Vector3d fixed_normal = other.cast<double>();
      if (moved_normal.dot(fixed_normal) < kLargestAngleCosine) continue;
      iteration.Add(moved, moved_normal, fixed[nearest[0].index], fixed_normal);
    }
    result.matches = iteration.matches();
    if (result.matches < kFewestMatches) {
      result.target_from_source = start;
      return result;
    }
    const Vector6d step = iteration.Solve(prior, LocalDifference(motion, start));
    if (!step.allFinite()) break;
    result.target_from_source = Retract(motion, step);
    constexpr double kSmallestStep = 1e-6;  // rad and m
    if (step.norm() < kSmallestStep) break;
  }
  return result;
}

}  // namespace backsight
