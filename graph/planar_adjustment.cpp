#include "graph/planar_adjustment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "graph/anderson_acceleration.h"

namespace backsight {
namespace {

using Status = PlanarAdjustmentResult::Status;
constexpr double kLargestDamping = 1e12;

/// Removes the fixed station's rows (a "reduced" vector or matrix has only free stations).
Eigen::VectorXd Reduced(const Eigen::VectorXd& full, int fixed) {
  Eigen::VectorXd reduced(full.size() - 6);
  reduced << full.head(6 * fixed), full.tail(full.size() - 6 * fixed - 6);
  return reduced;
}

Eigen::MatrixXd Reduced(const Eigen::MatrixXd& full, int fixed) {
  const Eigen::Index before = 6 * fixed;
  const Eigen::Index after = full.rows() - before - 6;
  Eigen::MatrixXd reduced(before + after, before + after);
  reduced << full.topLeftCorner(before, before), full.topRightCorner(before, after),
      full.bottomLeftCorner(after, before), full.bottomRightCorner(after, after);
  return reduced;
}

/// Poses in the chart about `reference` and back; only free stations have coordinates.
class Chart {
 public:
  Chart(std::span<const RigidTransform> reference, int fixed)
      : reference_(reference.begin(), reference.end()), fixed_(fixed) {}

  Eigen::VectorXd Coordinates(std::span<const RigidTransform> poses) const {
    Eigen::VectorXd full(static_cast<Eigen::Index>(6 * poses.size()));
    for (std::size_t s = 0; s < poses.size(); ++s) {
      full.segment<6>(static_cast<Eigen::Index>(6 * s)) = LocalDifference(poses[s], reference_[s]);
    }
    return Reduced(full, fixed_);
  }

  std::vector<RigidTransform> Poses(const Eigen::VectorXd& x) const { return Step(reference_, x); }

  /// Every free station of `poses` retracted by its part of the reduced vector `xi`.
  std::vector<RigidTransform> Step(std::span<const RigidTransform> poses,
                                   const Eigen::VectorXd& xi) const {
    std::vector<RigidTransform> moved(poses.begin(), poses.end());
    Eigen::Index row = 0;
    for (std::size_t s = 0; s < moved.size(); ++s) {
      if (static_cast<int>(s) == fixed_) continue;
      moved[s] = Retract(moved[s], xi.segment<6>(row));
      row += 6;
    }
    return moved;
  }

 private:
  std::vector<RigidTransform> reference_;
  int fixed_;
};

/// The blocked Cholesky where the matrix is positive definite to working precision, otherwise the
/// pivoted one, which is slower for many stations.
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  const Eigen::LLT<Eigen::MatrixXd> llt(matrix);
  if (llt.info() == Eigen::Success) return llt.solve(right);
  return matrix.ldlt().solve(right);
}

bool IsTinyStep(const Eigen::VectorXd& xi, const PlanarAdjustmentOptions& options) {
  for (Eigen::Index row = 0; row < xi.size(); row += 6) {
    if (xi.segment<3>(row).norm() >= options.smallest_rotation_rad ||
        xi.segment<3>(row + 3).norm() >= options.smallest_translation_m) {
      return false;
    }
  }
  return true;
}

/// Levenberg-Marquardt damping after Nielsen (IMM-REP-1999-05).
struct Damping {
  double value;
  double growth = 2.0;
  void Accepted(double gain_ratio) {
    value *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3.0));
    growth = 2.0;
  }
  void Rejected() {
    value *= growth;
    growth *= 2.0;
  }
};

}  // namespace

PlanarAdjustmentResult AdjustPlanes(const PlanarProblem& whole,
                                    std::span<const RigidTransform> start, int fixed_station,
                                    const PlanarAdjustmentOptions& options) {
  PlanarProblem problem = whole;
  problem.unneeded_station = fixed_station;
  PlanarAdjustmentResult result;
  result.poses.assign(start.begin(), start.end());
  NormalEquationsAssembler assembler;
  const NormalEquations& system = assembler.Assemble(problem, result.poses);
  result.start_cost = result.final_cost = system.cost;
  result.information = system.matrix;
  if (problem.planes.empty() || start.size() < 2) return result;

  const Chart chart(start, fixed_station);
  AndersonAccelerator accelerator(std::max(options.anderson_window, 1));
  Damping damping{options.start_damping};
  result.status = Status::kMaxIterations;
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    const Eigen::VectorXd gradient = Reduced(system.gradient, fixed_station);
    Eigen::MatrixXd matrix = Reduced(system.matrix, fixed_station);
    const Eigen::VectorXd damped = damping.value * matrix.diagonal().cwiseMax(1e-12);
    matrix.diagonal() += damped;
    const Eigen::VectorXd xi = -SolveSymmetric(matrix, gradient);
    const double expected = 0.5 * xi.dot(damped.cwiseProduct(xi) - gradient);
    std::vector<RigidTransform> stepped = chart.Step(result.poses, xi);
    double cost = xi.allFinite() ? PlanarCost(problem, stepped) : HUGE_VAL;

    if (!(cost <= system.cost)) {
      if (xi.allFinite() && IsTinyStep(xi, options)) {
        result.status = Status::kConverged;
        break;
      }
      damping.Rejected();
      accelerator.Reset();
      if (damping.value > kLargestDamping) {
        result.status = Status::kNoDescent;
        break;
      }
      continue;
    }

    const double decrease = system.cost - cost;
    damping.Accepted(expected > 0.0 ? decrease / expected : 1.0);
    if (options.anderson_window > 0) {
      const Eigen::VectorXd proposal =
          accelerator.Propose(chart.Coordinates(result.poses), chart.Coordinates(stepped));
      std::vector<RigidTransform> accelerated = chart.Poses(proposal);
      const double accelerated_cost = PlanarCost(problem, accelerated);
      if (accelerated_cost < cost) {
        stepped = std::move(accelerated);
        cost = accelerated_cost;
        ++result.anderson_accepted;
      }
    }
    const double before = system.cost;
    result.poses = std::move(stepped);
    assembler.Assemble(problem, result.poses);  // `system` is new
    if (before - cost <= options.relative_decrease * before || IsTinyStep(xi, options)) {
      result.status = Status::kConverged;
      break;
    }
  }
  for (RigidTransform& pose : result.poses) pose.rotation = NearestRotation(pose.rotation);
  result.final_cost = system.cost;
  result.information = system.matrix;
  return result;
}

PlanarAdjustmentResult AdjustPlanes(std::span<const WeightedPlane> planes,
                                    std::span<const PosePrior> priors,
                                    std::span<const RigidTransform> start, int fixed_station,
                                    const PlanarAdjustmentOptions& options) {
  return AdjustPlanes(PlanarProblem{planes, {priors, {}, {}}, nullptr}, start, fixed_station,
                      options);
}

}  // namespace backsight
