#include "stages/surface_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "stages/surface_pairs.h"

namespace backsight {
namespace {

constexpr double kReach = 2.0;                       // voxels, between matched means
const double kLargestAngleCosine = std::sqrt(0.75);  // 30 deg between matched normals
constexpr int kFewestMatches = 100;
constexpr double kGroupEdge = 20.0;        // voxels: errors farther apart are independent
constexpr double kFilledVoxel = 12.0;      // edge squared to variance of uniformly spread points
constexpr double kSharedError = 0.02;      // voxels: of all means together, whatever their number
constexpr std::size_t kFewestGroups = 30;  // five per unknown
using Options = SurfaceRefinementOptions;

/// Normal equations of one iteration with nearest neighbours under the current motion.
class Iteration {
 public:
  Iteration() = default;
  explicit Iteration(const SurfacePairSums& sums)
      : gradient_(sums.gradient.data()), matches_(static_cast<int>(sums.matches)) {
    std::size_t term = 0;
    for (Eigen::Index row = 0; row < 6; ++row) {
      for (Eigen::Index column = 0; column <= row; ++column) {
        matrix_(row, column) = matrix_(column, row) = sums.matrix[term++];
      }
    }
  }
  /// A pair of voxels and the covariance of their difference.
  void Add(const Eigen::Vector3d& moved, const Eigen::Vector3d& fixed,
           const Eigen::Matrix3d& covariance) {
    const Eigen::Matrix3d inverse = covariance.inverse();
    const Eigen::Vector3d residual = moved - fixed;
    constexpr double kCauchy2 = 2.4 * 2.4;  // 95 % efficiency where residuals are normal
    const double robust_weight =
        1.0 / (1.0 + kFilledVoxel * residual.dot(inverse * residual) / kCauchy2);
    const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(moved);
    const Eigen::Matrix<double, 6, 3> weighted = robust_weight * jacobian.transpose() * inverse;
    matrix_ += weighted * jacobian;
    const Vector6d gradient = weighted * residual;
    gradient_ += gradient;
    points_ += moved;
    squares_ += moved.squaredNorm();
    ++matches_;
    group_gradient_ = gradient;
  }
  /// The gradient of the pair added last.
  const Vector6d& last_gradient() const { return group_gradient_; }

  Vector6d Solve(const Matrix6d& prior, const Vector6d& prior_residual) const {
    const Matrix6d matrix = matrix_ + prior;
    return -matrix.ldlt().solve(gradient_ + prior * prior_residual);
  }
  int matches() const { return matches_; }
  const Matrix6d& matrix() const { return matrix_; }
  Eigen::Vector3d Center() const { return points_ / std::max(matches_, 1); }
  double Spread() const {
    const double mean_square = squares_ / std::max(matches_, 1) - Center().squaredNorm();
    return std::sqrt(std::max(mean_square, 0.0));
  }

 private:
  Matrix6d matrix_ = Matrix6d::Zero();
  Vector6d gradient_ = Vector6d::Zero();
  Vector6d group_gradient_ = Vector6d::Zero();
  Eigen::Vector3d points_ = Eigen::Vector3d::Zero();
  double squares_ = 0.0;
  int matches_ = 0;
};

/// Covariance of a voxel's mean by its own points, scaled so that a filled voxel's is its edge
/// squared (its points' is a twelfth); a few of them say little, so they count beside a filled
/// voxel.
Eigen::Matrix3d ClusterCovariance(const PointCluster& cluster, double l, double across_m) {
  constexpr double kPriorPoints = 3.0;
  const Eigen::Matrix3d filled = l * l / 12.0 * Eigen::Matrix3d::Identity();
  return kFilledVoxel * (cluster.scatter + kPriorPoints * filled) / (cluster.count + kPriorPoints) +
         across_m * across_m * Eigen::Matrix3d::Identity();
}

/// Nearest voxels of points that move little from one iteration to the next: a point that has moved
/// by less than its nearest voxel is closer than all others keeps it.
class NearestMemory {
 public:
  NearestMemory(const CloudIndex& index, double reach_m, std::size_t points)
      : index_(index), reach_m_(reach_m), entries_(points) {}

  /// The voxel nearest to point `i`, which now lies at `moved`; none within the reach: kNone.
  std::uint32_t Find(std::size_t i, const Eigen::Vector3d& moved) {
    Entry& entry = entries_[i];
    if (!IsCertain(entry, moved)) {
      const double wide_m = 1.1 * reach_m_;
      const auto nearest = index_.voxels.Nearest(index_.means, moved, wide_m);
      entry.asked = moved;
      entry.voxel = nearest ? nearest->voxel : kNone;
      entry.others_m = nearest ? std::sqrt(nearest->others_squared_m2) : wide_m;
    }
    if (entry.voxel == kNone || Distance(entry.voxel, moved) > reach_m_) return kNone;
    return entry.voxel;
  }

  static constexpr std::uint32_t kNone = ~0U;

 private:
  struct Entry {
    Eigen::Vector3d asked = Eigen::Vector3d::Zero();
    double others_m = 0.0;  // from where it was asked to all voxels but `voxel`, at least
    std::uint32_t voxel = kNone;
  };

  double Distance(std::uint32_t voxel, const Eigen::Vector3d& point) const {
    return (point - index_.means[voxel]).norm();
  }
  bool IsCertain(const Entry& entry, const Eigen::Vector3d& moved) const {
    constexpr double kRounding = 1e-9;
    const double others_m = entry.others_m - (moved - entry.asked).norm() - kRounding;
    return others_m > (entry.voxel == kNone ? reach_m_ : Distance(entry.voxel, moved));
  }

  const CloudIndex& index_;
  double reach_m_;
  std::vector<Entry> entries_;
};

EvenChoice Chosen(const Surface& source, const Options& options) {
  return {source.model.leaves.size(), options.sample};
}

/// The pairs under a motion, with the covariances of their own points; `groups`, if given, gets
/// their gradients by cubes of the source.
Iteration CollectClusters(const Surface& source, const Surface& target,
                          const RigidTransform& motion, const Options& options,
                          NearestMemory* memory, std::map<std::uint64_t, Vector6d>* groups) {
  const double l = target.model.resolution_m();
  const VoxelLattice lattice{.edge_m = kGroupEdge * l};
  const EvenChoice chosen = Chosen(source, options);
  Iteration iteration;
  for (std::size_t i = 0; i < chosen.count(); ++i) {
    const PointCluster& cluster = source.model.leaves[chosen[i]].cluster;
    const Eigen::Vector3d moved = motion * cluster.mean;
    const std::uint32_t j = memory->Find(i, moved);
    if (j == NearestMemory::kNone) continue;
    const PointCluster& fixed = target.model.leaves[j].cluster;
    const Eigen::Matrix3d own = ClusterCovariance(cluster, l, options.normal_sigma_m);
    iteration.Add(moved, fixed.mean,
                  motion.rotation * own * motion.rotation.transpose() +
                      ClusterCovariance(fixed, l, options.normal_sigma_m));
    if (groups == nullptr) continue;
    const auto [entry, is_new] = groups->try_emplace(lattice.Key(cluster.mean), Vector6d::Zero());
    entry->second += iteration.last_gradient();
  }
  return iteration;
}

SurfacePairRule RuleOf(const Options& options, double l) {
  return {.reach_m = kReach * l,
          .least_cosine = kLargestAngleCosine,
          .along_variance = l * l,
          .across_variance = options.normal_sigma_m * options.normal_sigma_m};
}

/// Steps from `result->target_from_source`, with what `iterate` says of a motion's pairs, until
/// they are small; false where too few match.
template <class Iterate>
bool Descend(const Matrix6d& prior, const Options& options, Iterate iterate,
             SurfaceRefinement* result) {
  const RigidTransform start = result->target_from_source;
  while (result->iterations < options.max_iterations) {
    ++result->iterations;
    const RigidTransform& motion = result->target_from_source;
    const Iteration iteration = iterate(motion);
    result->matches = iteration.matches();
    if (result->matches < kFewestMatches) {
      result->target_from_source = start;
      return false;
    }
    const Vector6d step = iteration.Solve(prior, LocalDifference(motion, start));
    if (!step.allFinite()) break;
    result->target_from_source = Retract(motion, step);
    constexpr double kSmallestStep = 1e-6;  // rad and m
    if (step.norm() < kSmallestStep) break;
  }
  return true;
}

/// Inverse of the cluster-robust covariance H^-1 M H^-1 and the error that all pairs share, about
/// the pairs' centre; zero where the groups are too few to tell M.
Matrix6d RobustInformation(const Iteration& last, const std::map<std::uint64_t, Vector6d>& groups,
                           double shared_m) {
  if (groups.size() < kFewestGroups) return Matrix6d::Zero();
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [key, gradient] : groups) scatter += gradient * gradient.transpose();
  const auto n = static_cast<double>(groups.size());
  scatter *= n / (n - 6.0);
  const Matrix6d inverse = last.matrix().inverse();
  Matrix6d shared = Matrix6d::Identity() * shared_m * shared_m;
  shared.topLeftCorner<3, 3>() /= std::pow(std::max(last.Spread(), 0.1), 2);
  Matrix6d about = Matrix6d::Identity();  // from a turn about the centre to one about the origin
  about.bottomLeftCorner<3, 3>() = Skew(last.Center());
  const Matrix6d covariance = inverse * scatter * inverse + about * shared * about.transpose();
  const Matrix6d information = covariance.inverse();
  if (!information.allFinite()) return Matrix6d::Zero();
  return 0.5 * (information + information.transpose());
}

}  // namespace

SurfaceRefinement RefineOnSurfaces(const Surface& source, const Surface& target,
                                   const CloudIndex& target_index, const RigidTransform& start,
                                   const Matrix6d& prior, const Options& options) {
  SurfaceRefinement result;
  result.target_from_source = start;
  const double l = target.model.resolution_m();
  if (options.covariance == Options::Covariance::kSurface) {
    SurfacePairs pairs(source, target, target_index, Chosen(source, options), kReach * l);
    const SurfacePairRule rule = RuleOf(options, l);
    Descend(
        prior, options,
        [&](const RigidTransform& motion) { return Iteration(pairs.Sum(motion, rule)); }, &result);
    return result;
  }
  NearestMemory memory(target_index, kReach * l, Chosen(source, options).count());
  const auto collect = [&](const RigidTransform& motion) {
    return CollectClusters(source, target, motion, options, &memory, nullptr);
  };
  if (!Descend(prior, options, collect, &result)) return result;
  std::map<std::uint64_t, Vector6d> groups;
  const Iteration last =
      CollectClusters(source, target, result.target_from_source, options, &memory, &groups);
  result.information = RobustInformation(last, groups, kSharedError * l);
  result.center = last.Center();
  result.spread_m = last.Spread();
  return result;
}

RigidTransform RefineRoughly(const Surface& source, const Surface& target,
                             const CloudIndex& target_index,
                             const RigidTransform& target_from_source) {
  SurfaceRefinementOptions few;
  few.normal_sigma_m = 0.1 * target.model.resolution_m();
  few.sample = 4000;
  few.max_iterations = 6;
  return RefineOnSurfaces(source, target, target_index, target_from_source, Matrix6d::Zero(), few)
      .target_from_source;
}

}  // namespace backsight
