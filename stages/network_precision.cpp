#include "stages/network_precision.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/voxel_grid.h"
#include "graph/planar_statistics.h"

namespace backsight {
namespace {

/// Grows the blocks while enough remain to tell, and keeps the largest factor: errors that
/// neighbouring planes share show only in blocks that hold the neighbours.
void ChooseVarianceFactor(const PrecisionInput& input, const Eigen::MatrixXd& formal,
                          const ExecutionContext& context, NetworkPrecision* precision) {
  constexpr double kFewestBlocks = 20.0;  // the factor's own standard error is then about a third
  constexpr int kDoublings = 5;
  double best = 0.0;
  for (int step = 0; step < kDoublings; ++step) {
    const double edge = input.smallest_block_m * std::pow(2.0, step);
    const std::vector<std::uint64_t> blocks = SpatialBlocks(input, edge);
    const VarianceFactor estimate =
        EstimateVarianceFactor(input.planes, input.surfaces, blocks, input.poses, formal, context);
    if (step > 0 && estimate.effective_blocks < kFewestBlocks) break;
    if (estimate.factor > best) {
      best = estimate.factor;
      precision->block_m = edge;
    }
  }
  // Noise-free data: the covariance must stay invertible.
  constexpr double kSmallestFactor = 1e-6;
  precision->variance_factor =
      std::max(best / (input.robust_slope * input.robust_slope), kSmallestFactor);
}

/// From a perturbation at the station's own position to one about the survey's origin.
Matrix6d AboutStation(const RigidTransform& pose) {
  Matrix6d about = Matrix6d::Identity();
  about.bottomLeftCorner<3, 3>() = Skew(pose.translation);
  return about;
}

void AddFloor(std::span<const RigidTransform> poses, const PrecisionFloor& floor,
              Eigen::MatrixXd* covariance) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(floor.rotation_rad * floor.rotation_rad),
      Eigen::Vector3d::Constant(floor.translation_m * floor.translation_m);
  const auto at = [&](std::size_t s) -> Matrix6d {
    const Matrix6d about = AboutStation(poses[s]);
    return about * variance.asDiagonal() * about.transpose();
  };
  const Matrix6d datum = at(0);  // a motion common to all others
  for (std::size_t s = 1; s < poses.size(); ++s) {
    const auto row = static_cast<Eigen::Index>(6 * s);
    covariance->block<6, 6>(row, row) += at(s);
    for (std::size_t t = 1; t < poses.size(); ++t) {
      covariance->block<6, 6>(row, static_cast<Eigen::Index>(6 * t)) += datum;
    }
  }
}

/// Per station: balanced parameters [lever * rotation; shift] about its planes' centre from xi.
std::vector<Matrix6d> Balances(const PrecisionInput& input) {
  const std::span<const RigidTransform> poses = input.poses;
  struct Sums {
    double count = 0.0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double squared = 0.0;
  };
  std::vector<Sums> sums(poses.size());
  for (const WeightedPlane& plane : input.planes) {
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

/// Power iteration on the balanced covariance: an eigenvalue problem of all stations would take
/// minutes where there are hundreds.
WeakestMotion FindWeakest(const PrecisionInput& input, const Eigen::MatrixXd& covariance) {
  const std::vector<Matrix6d> balances = Balances(input);
  const auto apply = [&](const Eigen::VectorXd& v, bool transposed) {
    Eigen::VectorXd out(v.size());
    for (std::size_t s = 0; s < balances.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(6 * s);
      if (transposed) {
        out.segment<6>(row) = balances[s].transpose() * v.segment<6>(row);
      } else {
        out.segment<6>(row) = balances[s] * v.segment<6>(row);
      }
    }
    return out;
  };
  Eigen::VectorXd v(covariance.rows());
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = 1.0 + 0.1 * std::sin(static_cast<double>(i));
  v.head<6>().setZero();
  v.normalize();
  double eigenvalue = 0.0;
  constexpr int kIterations = 300;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::VectorXd next = apply(covariance * apply(v, true), false);
    const double norm = next.norm();
    if (!(norm > 0.0)) break;
    const bool settled = std::abs(norm - eigenvalue) < 1e-9 * norm;
    eigenvalue = norm;
    v = next / norm;
    if (settled) break;
  }
  WeakestMotion weakest;
  weakest.sigma_m = std::sqrt(eigenvalue);
  weakest.direction = v;
  double most = -1.0;
  for (std::size_t s = 0; s < balances.size(); ++s) {
    const double moves = v.segment<6>(static_cast<Eigen::Index>(6 * s)).norm();
    if (moves > most) {
      most = moves;
      weakest.station = static_cast<int>(s);
    }
  }
  return weakest;
}

}  // namespace

Eigen::MatrixXd InvertInformation(const Eigen::MatrixXd& information) {
  const Eigen::Index free = information.rows() - 6;
  const Eigen::LLT<Eigen::MatrixXd> llt(information.bottomRightCorner(free, free));
  if (llt.info() != Eigen::Success) return {};
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(information.rows(), information.rows());
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(free, free));
  covariance.bottomRightCorner(free, free) = 0.5 * (inverse + inverse.transpose());
  if (!covariance.allFinite()) return {};
  return covariance;
}

std::vector<std::uint64_t> SpatialBlocks(const PrecisionInput& input, double edge_m) {
  const VoxelLattice lattice{.edge_m = edge_m};
  std::vector<std::uint64_t> blocks;
  blocks.reserve(input.planes.size() + input.surfaces.size());
  for (const WeightedPlane& plane : input.planes) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const PlaneObservation& o : plane.observations) {
      sum += input.poses[static_cast<std::size_t>(o.station)] * o.cluster.mean;
    }
    blocks.push_back(lattice.Key(sum / static_cast<double>(plane.observations.size())));
  }
  for (const LinkScore& score : input.surfaces) blocks.push_back(lattice.Key(score.center));
  return blocks;
}

Eigen::MatrixXd ScanInformation(const PrecisionInput& input, const ExecutionContext& context) {
  Eigen::MatrixXd matrix =
      AssembleNormalEquations({input.planes, {}, &context}, input.poses).matrix;
  for (const LinkScore& score : input.surfaces) {
    const Eigen::Index i = 6 * score.source;
    const Eigen::Index j = 6 * score.target;
    matrix.block<6, 6>(i, i) += score.matrix;
    matrix.block<6, 6>(j, j) += score.matrix;
    matrix.block<6, 6>(i, j) -= score.matrix;
    matrix.block<6, 6>(j, i) -= score.matrix;
  }
  return matrix;
}

NetworkPrecision ComputePrecision(const PrecisionInput& input, const PrecisionFloor& floor,
                                  const ExecutionContext& context) {
  NetworkPrecision precision;
  const Eigen::MatrixXd of_scans = ScanInformation(input, context);
  const Eigen::MatrixXd of_others =
      AssembleNormalEquations({{}, input.others, nullptr}, input.poses).matrix;
  const Eigen::MatrixXd formal = InvertInformation(of_scans + of_others);
  if (formal.size() == 0) return precision;
  ChooseVarianceFactor(input, formal, context, &precision);
  precision.covariance = InvertInformation(of_scans / precision.variance_factor + of_others);
  if (precision.covariance.size() == 0) return precision;
  precision.weakest = FindWeakest(input, precision.covariance);
  AddFloor(input.poses, floor, &precision.covariance);
  precision.valid = true;
  return precision;
}

}  // namespace backsight
