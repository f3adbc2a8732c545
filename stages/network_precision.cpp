#include "stages/network_precision.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/voxel_grid.h"
#include "graph/jackknife_scatter.h"
#include "graph/planar_statistics.h"
#include "graph/pose_observations.h"
#include "stages/principal_motions.h"

namespace backsight {
namespace {

/// Grows the blocks while enough remain to tell, and keeps the largest factor: errors that
/// neighbouring planes share show only in blocks that hold the neighbours. Returns the edge of the
/// blocks that tell most and are enough for single motions, too, which depend on few stations.
double ChooseVarianceFactor(const PrecisionInput& input, const Eigen::MatrixXd& formal,
                            const ExecutionContext& context, NetworkPrecision* precision) {
  constexpr double kFewestBlocks = 20.0;  // the factor's own standard error is then about a third
  constexpr double kFewestPerStation = 4.0;
  constexpr int kDoublings = 5;
  const double fewest_for_motions =
      std::max(kFewestBlocks, kFewestPerStation * static_cast<double>(input.poses.size() - 1));
  double best = 0.0;
  double best_for_motions = 0.0;
  double edge_for_motions_m = input.smallest_block_m;
  for (int step = 0; step < kDoublings; ++step) {
    const double edge = input.smallest_block_m * std::pow(2.0, step);
    const std::vector<std::uint64_t> blocks = SpatialBlocks(input, edge);
    const VarianceFactor estimate = EstimateVarianceFactor({input.planes, input.surfaces, blocks},
                                                           input.poses, formal, context);
    if (step > 0 && estimate.effective_blocks < kFewestBlocks) break;
    if (estimate.factor > best) {
      best = estimate.factor;
      precision->block_m = edge;
    }
    if (estimate.effective_blocks >= fewest_for_motions && estimate.factor > best_for_motions) {
      best_for_motions = estimate.factor;
      edge_for_motions_m = edge;
    }
  }
  // Noise-free data: the covariance must stay invertible.
  constexpr double kSmallestFactor = 1e-6;
  precision->variance_factor =
      std::max(best / (input.robust_slope * input.robust_slope), kSmallestFactor);
  return edge_for_motions_m;
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

/// How the poses really resist motions: the exact curvature of the planes, the surfaces across
/// themselves, and all else.
Eigen::MatrixXd Resistance(const PrecisionInput& input, const Eigen::MatrixXd& of_others,
                           const ExecutionContext& context) {
  PlanarProblem problem{input.planes, {}, &context};
  problem.curvature = PlaneCurvature::kExact;
  Eigen::MatrixXd matrix =
      input.robust_slope * AssembleNormalEquations(problem, input.poses).matrix + of_others;
  for (const LinkScore& score : input.surfaces) {
    AddRelative(6 * score.source, 6 * score.target, score.known, &matrix);
  }
  return matrix;
}

/// The inverse of the resistance, but of no motion less than an eighth of what is claimed: along
/// what nothing holds it is as good as any number, also below zero. Nothing where the claim is
/// singular.
Eigen::MatrixXd InvertResistance(const Eigen::MatrixXd& resistance,
                                 const Eigen::MatrixXd& claimed) {
  constexpr double kLeastShare = 0.125;
  const Eigen::Index free = claimed.rows() - 6;
  const Eigen::LLT<Eigen::MatrixXd> root(claimed.bottomRightCorner(free, free));
  if (root.info() != Eigen::Success) return {};
  const auto lower = root.matrixL();
  const Eigen::MatrixXd half = lower.solve(resistance.bottomRightCorner(free, free));
  const Eigen::MatrixXd whole = lower.solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (whole + whole.transpose()));
  const Eigen::VectorXd shares = solver.eigenvalues().cwiseMax(kLeastShare);
  const Eigen::MatrixXd motions = root.matrixU().solve(solver.eigenvectors());
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(claimed.rows(), claimed.rows());
  inverse.bottomRightCorner(free, free) =
      motions * shares.cwiseInverse().asDiagonal() * motions.transpose();
  return inverse;
}

/// By how much the variance of every motion (a column of `dual`, their product with the claimed
/// information) is larger than the one claimed: by the scatter of the blocks' pulls and how the
/// poses resist them. One variance factor for all motions is that of most of them, not of the few
/// that hardly any surface faces. Never below zero: the scatter is an estimate, too.
Eigen::VectorXd ExcessVariances(const PrecisionInput& input, const Eigen::MatrixXd& of_scans,
                                const Eigen::MatrixXd& of_others, const Eigen::MatrixXd& dual,
                                double block_m, const ExecutionContext& context) {
  const Eigen::MatrixXd inverse = InvertResistance(Resistance(input, of_others, context),
                                                   input.robust_slope * of_scans + of_others);
  if (inverse.size() == 0) return Eigen::VectorXd::Zero(dual.cols());
  context.CheckStop();
  const std::vector<std::uint64_t> blocks = SpatialBlocks(input, block_m);
  const Eigen::MatrixXd scatter =
      JackknifeScatter({input.planes, input.surfaces, blocks}, input.poses, input.robust_slope,
                       inverse, context) +
      of_others;
  const Eigen::MatrixXd pulled = inverse * dual;
  const Eigen::VectorXd variances =
      pulled.cwiseProduct(scatter * pulled).colwise().sum().transpose();
  return (variances.array() <= 1.0).select(0.0, variances.array() - 1.0);  // keeps NaN
}

WeakestMotion WeakestOf(const PrincipalMotions& motions, const Eigen::VectorXd& excess) {
  const Eigen::VectorXd sigmas =
      motions.sigmas_m.cwiseProduct((1.0 + excess.array()).sqrt().matrix());
  Eigen::Index weakest = 0;
  WeakestMotion motion;
  motion.sigma_m = sigmas.maxCoeff(&weakest);
  motion.direction = motions.directions.col(weakest);
  double most = -1.0;
  for (Eigen::Index row = 0; row < motion.direction.size(); row += 6) {
    const double moves = motion.direction.segment<6>(row).norm();
    if (moves > most) {
      most = moves;
      motion.station = static_cast<int>(row / 6);
    }
  }
  return motion;
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
    AddRelative(6 * score.source, 6 * score.target, score.matrix, &matrix);
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
  const double block_m = ChooseVarianceFactor(input, formal, context, &precision);
  const Eigen::MatrixXd claimed = of_scans / precision.variance_factor + of_others;
  precision.covariance = InvertInformation(claimed);
  if (precision.covariance.size() == 0) return precision;
  const PrincipalMotions motions =
      FindPrincipalMotions(input.planes, input.poses, precision.covariance);
  const Eigen::VectorXd excess =
      ExcessVariances(input, of_scans, of_others, claimed * motions.steps, block_m, context);
  precision.covariance += motions.steps * excess.asDiagonal() * motions.steps.transpose();
  precision.covariance = 0.5 * (precision.covariance + precision.covariance.transpose()).eval();
  precision.weakest = WeakestOf(motions, excess);
  AddFloor(input.poses, floor, &precision.covariance);
  precision.valid = precision.covariance.allFinite();
  return precision;
}

}  // namespace backsight
