#include "graph/pose_graph.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/spanning_tree.h"

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

/// Weight of a squared error r2 under truncated least squares smoothed by mu (Yang et al. 2020,
/// doi 10.1109/LRA.2020.2965893, Eq. 14).
double TruncatedWeight(double r2, double c2, double mu) {
  if (r2 <= mu / (mu + 1.0) * c2) return 1.0;
  if (r2 >= (mu + 1.0) / mu * c2) return 0.0;
  return std::sqrt(c2 * mu * (mu + 1.0) / r2) - mu;
}

/// Graduated non-convexity: from nearly quadratic (small mu) to truncated (large mu).
void SolveRobust(std::span<const PoseGraphLink> links, const PoseGraphOptions& options,
                 const std::vector<char>& fixed, PoseGraphResult* result) {
  const double c2 = options.outlier_limit;
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
    AdjustPoses(links, result->weights, fixed, options.max_iterations,
                &result->survey_from_station);
    ++result->rounds;
    if (decided) break;
    mu *= kGrowth;
  }
  for (double& weight : result->weights) weight = weight >= 0.5 ? 1.0 : 0.0;
}

}  // namespace

Vector6d LinkResidual(const PoseGraphLink& link, const RigidTransform& survey_from_source,
                      const RigidTransform& survey_from_target) {
  return LocalDifference(survey_from_target.Inverse() * survey_from_source,
                         link.target_from_source);
}

double SquaredError(const PoseGraphLink& link, std::span<const RigidTransform> poses) {
  const Vector6d r = LinkResidual(link, poses[static_cast<std::size_t>(link.source)],
                                  poses[static_cast<std::size_t>(link.target)]);
  return r.dot(link.information * r);
}

std::vector<char> FirstOfEachComponent(const std::vector<int>& component) {
  std::vector<char> first(component.size(), 0);
  int next = 0;
  for (std::size_t s = 0; s < component.size(); ++s) {
    if (component[s] == next) first[s] = 1, ++next;
  }
  return first;
}

void ResetDatum(const std::vector<int>& component, std::vector<RigidTransform>* poses) {
  std::vector<RigidTransform> datum_from_survey;
  for (std::size_t s = 0; s < poses->size(); ++s) {
    const auto c = static_cast<std::size_t>(component[s]);
    if (c == datum_from_survey.size()) {
      datum_from_survey.push_back((*poses)[s].Inverse());
      (*poses)[s] = RigidTransform{};
      continue;
    }
    RigidTransform& pose = (*poses)[s];
    pose = datum_from_survey[c] * pose;
    pose.rotation = NearestRotation(pose.rotation);
  }
}

bool AdjustPoses(std::span<const PoseGraphLink> links, const std::vector<double>& weights,
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

PoseGraphResult SolvePoseGraph(int stations, std::span<const PoseGraphLink> links,
                               std::span<const RigidTransform> start,
                               const PoseGraphOptions& options) {
  PoseGraphResult result;
  const SpanningForest forest = BuildSpanningForest(stations, links, {});
  result.survey_from_station = forest.survey_from_station;
  if (!start.empty()) result.survey_from_station.assign(start.begin(), start.end());
  result.component = forest.component;
  ResetDatum(result.component, &result.survey_from_station);
  result.weights.assign(links.size(), 1.0);
  if (links.empty()) return result;
  const std::vector<char> fixed = FirstOfEachComponent(result.component);
  if (options.robust) SolveRobust(links, options, fixed, &result);
  result.converged = AdjustPoses(links, result.weights, fixed, options.max_iterations,
                                 &result.survey_from_station);
  ++result.rounds;
  for (std::size_t l = 0; l < links.size(); ++l) {
    result.cost += 0.5 * result.weights[l] * SquaredError(links[l], result.survey_from_station);
  }
  return result;
}

}  // namespace backsight
