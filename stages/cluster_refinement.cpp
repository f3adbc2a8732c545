#include "stages/cluster_refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/even_choice.h"
#include "core/voxel_grid.h"
#include "stages/motion_descent.h"

namespace backsight {
namespace {

constexpr std::size_t kVoxels = 40000;  // of the source
constexpr int kMostSteps = 10;
constexpr double kReach = 2.0;             // voxels, between matched means
constexpr double kAcrossSigma = 0.001;     // m, of any mean
constexpr double kGroupEdge = 20.0;        // voxels: errors farther apart are independent
constexpr double kFilledVoxel = 12.0;      // edge squared to variance of uniformly spread points
constexpr double kSharedError = 0.02;      // voxels: of all means together, whatever their number
constexpr std::size_t kFewestGroups = 30;  // five per unknown

/// What the pairs of one motion amount to.
class PairSums {
 public:
  /// A pair of voxels and the covariance of their difference; returns its gradient.
  Vector6d Add(const Eigen::Vector3d& moved, const Eigen::Vector3d& fixed,
               const Eigen::Matrix3d& covariance) {
    const Eigen::Matrix3d inverse = covariance.inverse();
    const Eigen::Vector3d residual = moved - fixed;
    constexpr double kCauchy2 = 2.4 * 2.4;  // 95 % efficiency where residuals are normal
    const double robust_weight =
        1.0 / (1.0 + kFilledVoxel * residual.dot(inverse * residual) / kCauchy2);
    const Eigen::Matrix<double, 3, 6> jacobian = PointJacobian(moved);
    const Eigen::Matrix<double, 6, 3> weighted = robust_weight * jacobian.transpose() * inverse;
    equations_.matrix += weighted * jacobian;
    const Vector6d gradient = weighted * residual;
    equations_.gradient += gradient;
    ++equations_.matches;
    points_ += moved;
    squares_ += moved.squaredNorm();
    return gradient;
  }
  const MotionEquations& equations() const { return equations_; }
  Eigen::Vector3d Center() const { return points_ / std::max(equations_.matches, 1); }
  double Spread() const {
    const double mean_square = squares_ / std::max(equations_.matches, 1) - Center().squaredNorm();
    return std::sqrt(std::max(mean_square, 0.0));
  }

 private:
  MotionEquations equations_;
  Eigen::Vector3d points_ = Eigen::Vector3d::Zero();
  double squares_ = 0.0;
};

/// Covariance of a voxel's mean by its own points, scaled so that a filled voxel's is its edge
/// squared (its points' is a twelfth); a few of them say little, so they count beside a filled
/// voxel.
Eigen::Matrix3d ClusterCovariance(const PointCluster& cluster, double l) {
  constexpr double kPriorPoints = 3.0;
  const Eigen::Matrix3d filled = l * l / 12.0 * Eigen::Matrix3d::Identity();
  return kFilledVoxel * (cluster.scatter + kPriorPoints * filled) / (cluster.count + kPriorPoints) +
         kAcrossSigma * kAcrossSigma * Eigen::Matrix3d::Identity();
}

/// Nearest voxels of points that move little from one iteration to the next: a point that has moved
/// by less than its nearest voxel is closer than all others keeps it.
class NearestMemory {
 public:
  NearestMemory(const StationModel& model, const CloudIndex& index, double reach_m,
                std::size_t points)
      : means_(model.leaves.means()), index_(index), reach_m_(reach_m), entries_(points) {}

  /// The voxel nearest to point `i`, which now lies at `moved`; none within the reach: kNone.
  std::uint32_t Find(std::size_t i, const Eigen::Vector3d& moved) {
    Entry& entry = entries_[i];
    if (!IsCertain(entry, moved)) {
      const double wide_m = 1.1 * reach_m_;
      const auto nearest = index_.voxels.Nearest(means_, moved, wide_m);
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
    return (point - means_[voxel]).norm();
  }
  bool IsCertain(const Entry& entry, const Eigen::Vector3d& moved) const {
    constexpr double kRounding = 1e-9;
    const double others_m = entry.others_m - (moved - entry.asked).norm() - kRounding;
    return others_m > (entry.voxel == kNone ? reach_m_ : Distance(entry.voxel, moved));
  }

  const VoxelPoints& means_;
  const CloudIndex& index_;
  double reach_m_;
  std::vector<Entry> entries_;
};

using Groups = std::map<std::uint64_t, Vector6d>;

/// The pairs under a motion; `groups`, if given, gets their gradients by cubes of the source.
PairSums CollectPairs(const Surface& source, const Surface& target, const RigidTransform& motion,
                      const EvenChoice& chosen, NearestMemory* memory, Groups* groups) {
  const double l = target.model.resolution_m();
  const VoxelLattice lattice{.edge_m = kGroupEdge * l};
  PairSums sums;
  for (std::size_t i = 0; i < chosen.count(); ++i) {
    const PointCluster cluster = source.model.leaves.Cluster(chosen[i]);
    const Eigen::Vector3d moved = motion * cluster.mean;
    const std::uint32_t j = memory->Find(i, moved);
    if (j == NearestMemory::kNone) continue;
    const PointCluster fixed = target.model.leaves.Cluster(j);
    const Eigen::Matrix3d& rotation = motion.rotation;
    const Vector6d gradient =
        sums.Add(moved, fixed.mean,
                 rotation * ClusterCovariance(cluster, l) * rotation.transpose() +
                     ClusterCovariance(fixed, l));
    if (groups == nullptr) continue;
    groups->try_emplace(lattice.Key(cluster.mean), Vector6d::Zero()).first->second += gradient;
  }
  return sums;
}

/// Inverse of the cluster-robust covariance H^-1 M H^-1 and the error that all pairs share, about
/// the pairs' centre; zero where the groups are too few to tell M.
Matrix6d RobustInformation(const PairSums& last, const Groups& groups, double shared_m) {
  if (groups.size() < kFewestGroups) return Matrix6d::Zero();
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [key, gradient] : groups) scatter += gradient * gradient.transpose();
  const auto n = static_cast<double>(groups.size());
  scatter *= n / (n - 6.0);
  const Matrix6d inverse = last.equations().matrix.inverse();
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

ClusterRefinement RefineOnClusters(const Surface& source, const Surface& target,
                                   const CloudIndex& target_index, const RigidTransform& start,
                                   const Matrix6d& prior) {
  const double l = target.model.resolution_m();
  const EvenChoice chosen(source.model.leaves.size(), kVoxels);
  NearestMemory memory(target.model, target_index, kReach * l, chosen.count());
  const auto equations_at = [&](const RigidTransform& motion) {
    return CollectPairs(source, target, motion, chosen, &memory, nullptr).equations();
  };
  const MotionDescent descent = Descend(start, prior, kMostSteps, equations_at);
  ClusterRefinement result{descent.target_from_source, descent.matches};
  if (!descent.has_enough) return result;
  Groups groups;
  const PairSums last =
      CollectPairs(source, target, result.target_from_source, chosen, &memory, &groups);
  result.information = RobustInformation(last, groups, kSharedError * l);
  result.center = last.Center();
  result.spread_m = last.Spread();
  return result;
}

}  // namespace backsight
