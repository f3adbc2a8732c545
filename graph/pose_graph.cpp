#include "graph/pose_graph.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/spanning_tree.h"
#include "graph/station_placement.h"

namespace backsight {
namespace {

/// A pose as Ceres sees it.
struct PoseBlock {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
};

/// A root with root^T root = information, also where that is singular (a corridor's link does not
/// know the direction along it), which a Cholesky factor would spoil.
Matrix6d SquareRoot(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information);
  const Vector6d roots = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return roots.asDiagonal() * solver.eigenvectors().transpose();
}

/// LinkResidual times the square root of the information, for automatic differentiation.
class LinkCost {
 public:
  explicit LinkCost(const PoseGraphLink& link)
      : measured_rotation_(link.target_from_source.rotation),
        measured_translation_(link.target_from_source.translation),
        root_(SquareRoot(link.information)) {}

  template <typename T>
  bool operator()(const T* source_rotation, const T* source_translation, const T* target_rotation,
                  const T* target_translation, T* residual) const {
    using Quaternion = Eigen::Quaternion<T>;
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Quaternion> rs(source_rotation);
    const Eigen::Map<const Quaternion> rt(target_rotation);
    const Eigen::Map<const Vector> ts(source_translation);
    const Eigen::Map<const Vector> tt(target_translation);

    const Quaternion delta =
        rt.conjugate() * rs * measured_rotation_.template cast<T>().conjugate();
    const T wxyz[4] = {delta.w(), delta.x(), delta.y(), delta.z()};
    Eigen::Matrix<T, 6, 1> r;
    ceres::QuaternionToAngleAxis(wxyz, r.data());
    r.template tail<3>() =
        rt.conjugate() * (ts - tt) - delta * measured_translation_.template cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> whitened(residual);
    whitened = root_.template cast<T>() * r;
    return true;
  }

 private:
  Eigen::Quaterniond measured_rotation_;
  Eigen::Vector3d measured_translation_;
  Matrix6d root_;
};

/// One Ceres solution with the links' weights held; `fixed[s]` stations do not move.
bool SolveWeighted(std::span<const PoseGraphLink> links, const std::vector<double>& weights,
                   const std::vector<char>& fixed, int max_iterations,
                   std::vector<RigidTransform>* poses) {
  std::vector<PoseBlock> blocks;
  for (const RigidTransform& pose : *poses) blocks.push_back({pose.Quaternion(), pose.translation});

  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::EigenQuaternionManifold quaternion_manifold;
  ceres::Problem problem(problem_options);
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    double* rotation = blocks[s].rotation.coeffs().data();
    problem.AddParameterBlock(rotation, 4, &quaternion_manifold);
    problem.AddParameterBlock(blocks[s].translation.data(), 3);
    if (fixed[s] != 0) {
      problem.SetParameterBlockConstant(rotation);
      problem.SetParameterBlockConstant(blocks[s].translation.data());
    }
  }
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (weights[l] <= 0.0) continue;
    PoseBlock& source = blocks[static_cast<std::size_t>(links[l].source)];
    PoseBlock& target = blocks[static_cast<std::size_t>(links[l].target)];
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LinkCost, 6, 4, 3, 4, 3>(new LinkCost(links[l])),
        new ceres::ScaledLoss(nullptr, weights[l], ceres::TAKE_OWNERSHIP),
        source.rotation.coeffs().data(), source.translation.data(), target.rotation.coeffs().data(),
        target.translation.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;  // one order of additions, so one result
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    if (fixed[s] != 0) continue;
    (*poses)[s] = RigidTransform::FromQuaternion(blocks[s].rotation, blocks[s].translation);
  }
  return summary.termination_type == ceres::CONVERGENCE;
}

/// Weight of a squared error r2 under truncated least squares smoothed by mu (Yang et al. 2020,
/// doi 10.1109/LRA.2020.2965893, Eq. 14).
double TruncatedWeight(double r2, double c2, double mu) {
  if (r2 <= mu / (mu + 1.0) * c2) return 1.0;
  if (r2 >= (mu + 1.0) / mu * c2) return 0.0;
  return std::sqrt(c2 * mu * (mu + 1.0) / r2) - mu;
}

std::vector<char> FirstOfEachComponent(const std::vector<int>& component) {
  std::vector<char> first(component.size(), 0);
  int next = 0;
  for (std::size_t s = 0; s < component.size(); ++s) {
    if (component[s] == next) first[s] = 1, ++next;
  }
  return first;
}

/// Graduated non-convexity: from nearly quadratic (small mu) to truncated (large mu).
void SolveRobust(std::span<const PoseGraphLink> links, const PoseGraphOptions& options,
                 const std::vector<char>& fixed, PoseGraphResult* result) {
  const double c2 = options.outlier_quantile;
  constexpr double kGrowth = 1.4;
  constexpr int kMaxRounds = 100;
  double largest = 0.0;
  for (const PoseGraphLink& link : links) {
    largest = std::max(largest, SquaredError(link, result->survey_from_station));
  }
  if (largest <= c2) return;
  double mu = c2 / (2.0 * largest - c2);
  for (int round = 0; round < kMaxRounds; ++round) {
    bool decided = true;
    for (std::size_t l = 0; l < links.size(); ++l) {
      result->weights[l] =
          TruncatedWeight(SquaredError(links[l], result->survey_from_station), c2, mu);
      decided &= result->weights[l] == 0.0 || result->weights[l] == 1.0;
    }
    SolveWeighted(links, result->weights, fixed, options.max_iterations,
                  &result->survey_from_station);
    ++result->rounds;
    if (decided) break;
    mu *= kGrowth;
  }
  for (double& weight : result->weights) weight = weight >= 0.5 ? 1.0 : 0.0;
}

/// Tries to better the result by moving single stations (graduated non-convexity may leave one on a
/// false link although most of its links agree elsewhere) and by taking true links back in.
void MendAssignment(std::span<const PoseGraphLink> links, const PoseGraphOptions& options,
                    const std::vector<char>& fixed, PoseGraphResult* result) {
  const double c2 = options.outlier_quantile;
  // A station placed by one link carries that link's noise too, and a link left out fits worse than
  // it would if it took part: a wide limit to begin with.
  double limit = 4.0 * c2;
  std::vector<RigidTransform> poses = result->survey_from_station;
  MoveStationsToConsensus(links, result->component, limit, &poses);
  std::vector<double> weights;
  constexpr int kMaxRounds = 10;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<double> next;
    for (const PoseGraphLink& link : links) {
      next.push_back(SquaredError(link, poses) <= limit ? 1.0 : 0.0);
    }
    if (next == weights && limit == c2) break;
    if (round > 0) limit = c2;
    weights = std::move(next);
    SolveWeighted(links, weights, fixed, options.max_iterations, &poses);
    ++result->rounds;
  }
  if (TruncatedCost(links, poses, c2) < TruncatedCost(links, result->survey_from_station, c2)) {
    result->survey_from_station = std::move(poses);
    result->weights = std::move(weights);
  }
}

/// Gauss-Newton matrix of the accepted links in Retract's convention, six rows per station.
Eigen::MatrixXd Information(int stations, std::span<const PoseGraphLink> links,
                            const PoseGraphResult& result) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(6 * stations, 6 * stations);
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (result.weights[l] <= 0.0) continue;
    const PoseGraphLink& link = links[l];
    const auto& source = result.survey_from_station[static_cast<std::size_t>(link.source)];
    const auto& target = result.survey_from_station[static_cast<std::size_t>(link.target)];
    const Matrix6d jacobian =
        LocalDifferenceJacobian(LinkResidual(link, source, target)) * Adjoint(target.Inverse());
    const Matrix6d block = jacobian.transpose() * link.information * jacobian;
    const Eigen::Index i = 6 * link.source;
    const Eigen::Index j = 6 * link.target;
    matrix.block<6, 6>(i, i) += block;
    matrix.block<6, 6>(j, j) += block;
    matrix.block<6, 6>(i, j) -= block;
    matrix.block<6, 6>(j, i) -= block;
  }
  return matrix;
}

void ComputeCovariance(int stations, std::span<const PoseGraphLink> links,
                       const std::vector<char>& fixed, PoseGraphResult* result) {
  Eigen::MatrixXd matrix = Information(stations, links, *result);
  for (int s = 0; s < stations; ++s) {
    if (fixed[static_cast<std::size_t>(s)] == 0) continue;
    matrix.middleRows(6 * s, 6).setZero();
    matrix.middleCols(6 * s, 6).setZero();
    matrix.block<6, 6>(6 * s, 6 * s).setIdentity();
  }
  const Eigen::MatrixXd inverse =
      matrix.ldlt().solve(Eigen::MatrixXd::Identity(6 * stations, 6 * stations));
  for (int s = 0; s < stations; ++s) {
    result->covariance.push_back(fixed[static_cast<std::size_t>(s)] != 0
                                     ? Matrix6d(Matrix6d::Zero())
                                     : Matrix6d(inverse.block<6, 6>(6 * s, 6 * s)));
  }
}

}  // namespace

Vector6d LinkResidual(const PoseGraphLink& link, const RigidTransform& survey_from_source,
                      const RigidTransform& survey_from_target) {
  return LocalDifference(survey_from_target.Inverse() * survey_from_source,
                         link.target_from_source);
}

PoseGraphResult SolvePoseGraph(int stations, std::span<const PoseGraphLink> links,
                               const PoseGraphOptions& options) {
  PoseGraphResult result;
  SpanningForest forest = BuildSpanningForest(stations, links, {});
  result.survey_from_station = forest.survey_from_station;
  result.weights.assign(links.size(), 1.0);
  std::vector<char> fixed = FirstOfEachComponent(forest.component);
  if (!links.empty()) {
    result.converged = SolveWeighted(links, result.weights, fixed, options.max_iterations,
                                     &result.survey_from_station);
    result.rounds = 1;
    result.component = forest.component;
    if (options.robust) SolveRobust(links, options, fixed, &result);
    if (options.robust) MendAssignment(links, options, fixed, &result);
  }

  // Without the false links the network may fall apart: form the components anew.
  std::vector<char> use(links.size());
  for (std::size_t l = 0; l < links.size(); ++l) use[l] = result.weights[l] > 0.0 ? 1 : 0;
  forest = BuildSpanningForest(stations, links, use);
  result.component = forest.component;
  fixed = FirstOfEachComponent(forest.component);
  for (std::size_t s = 0; s < fixed.size(); ++s) {
    if (fixed[s] != 0) result.survey_from_station[s] = RigidTransform{};
  }
  if (std::find(use.begin(), use.end(), 0) != use.end()) {
    result.survey_from_station = forest.survey_from_station;
  }
  if (!links.empty()) {
    result.converged = SolveWeighted(links, result.weights, fixed, options.max_iterations,
                                     &result.survey_from_station);
  }
  for (std::size_t l = 0; l < links.size(); ++l) {
    result.cost += 0.5 * result.weights[l] * SquaredError(links[l], result.survey_from_station);
  }
  ComputeCovariance(stations, links, fixed, &result);
  return result;
}

}  // namespace backsight
