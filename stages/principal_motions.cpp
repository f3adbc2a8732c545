#include "stages/principal_motions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace backsight {
namespace {

/// Per station: balanced parameters [lever * rotation; shift] about its planes' centre from xi.
std::vector<Matrix6d> Balances(std::span<const WeightedPlane> planes,
                               std::span<const RigidTransform> poses) {
  struct Sums {
    double count = 0.0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double squared = 0.0;
  };
  std::vector<Sums> sums(poses.size());
  for (const WeightedPlane& plane : planes) {
    for (const PlaneObservation& o : plane.observations) {
      const auto s = static_cast<std::size_t>(o.station);
      const Eigen::Vector3d offset = poses[s] * o.cluster.mean - sums[s].mean;
      sums[s].count += 1.0;
      sums[s].mean += offset / sums[s].count;
      sums[s].squared += offset.dot(poses[s] * o.cluster.mean - sums[s].mean);
    }
  }
  std::vector<Matrix6d> balances;
  for (std::size_t s = 0; s < poses.size(); ++s) {
    const bool seen = sums[s].count > 1.0;
    const Eigen::Vector3d center = seen ? sums[s].mean : poses[s].translation;
    constexpr double kShortestLever = 0.1;
    const double lever =
        std::max(seen ? std::sqrt(sums[s].squared / sums[s].count) : 1.0, kShortestLever);
    Matrix6d balance = Matrix6d::Identity();
    balance.topLeftCorner<3, 3>() *= lever;
    balance.bottomLeftCorner<3, 3>() = -Skew(center);
    balances.push_back(balance);
  }
  return balances;
}

}  // namespace

PrincipalMotions FindPrincipalMotions(std::span<const WeightedPlane> planes,
                                      std::span<const RigidTransform> poses,
                                      const Eigen::MatrixXd& covariance) {
  const std::vector<Matrix6d> balances = Balances(planes, poses);
  const Eigen::Index free = covariance.rows() - 6;
  Eigen::MatrixXd balanced = covariance.bottomRightCorner(free, free);
  for (Eigen::Index row = 0; row < free; row += 6) {
    const Matrix6d& balance = balances[static_cast<std::size_t>(row / 6 + 1)];
    balanced.middleRows<6>(row) = (balance * balanced.middleRows<6>(row)).eval();
    balanced.middleCols<6>(row) = (balanced.middleCols<6>(row) * balance.transpose()).eval();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(balanced);
  PrincipalMotions motions;
  motions.sigmas_m = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  motions.directions = Eigen::MatrixXd::Zero(covariance.rows(), free);
  motions.directions.bottomRows(free) = solver.eigenvectors();
  motions.steps = motions.directions * motions.sigmas_m.asDiagonal();
  for (Eigen::Index row = 6; row < covariance.rows(); row += 6) {
    const Matrix6d& balance = balances[static_cast<std::size_t>(row / 6)];
    motions.steps.middleRows<6>(row) =
        balance.partialPivLu().solve(motions.steps.middleRows<6>(row)).eval();
  }
  return motions;
}

}  // namespace backsight
