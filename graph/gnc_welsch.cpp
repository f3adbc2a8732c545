#include "graph/gnc_welsch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/rigid_fit.h"

namespace backsight {
namespace {

void SetSquaredResiduals(const Correspondences& c, const RigidTransform& transform,
                         std::vector<double>* squared) {
  for (std::size_t a = 0; a < c.size(); ++a) {
    (*squared)[a] = (transform * c.source[a] - c.target[a]).squaredNorm();
  }
}

/// Per-axis standard deviation from the median length of 3-vectors with normal entries: the
/// Maxwell distribution's median is 1.538 standard deviations.
double MedianSd(std::vector<double> squared, double limit_m) {
  std::erase_if(squared, [&](double s) { return s >= limit_m * limit_m; });
  if (squared.empty()) return 0.0;
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return std::sqrt(*middle) / 1.538;
}

Matrix6d Information(const Correspondences& c, const GncWelschResult& result) {
  Matrix6d information = Matrix6d::Zero();
  for (std::size_t a = 0; a < c.size(); ++a) {
    const Eigen::Matrix<double, 3, 6> jacobian =
        PointJacobian(result.target_from_source * c.source[a]);
    information += result.weights[a] * jacobian.transpose() * jacobian;
  }
  return information / (result.residual_sd_m * result.residual_sd_m);
}

constexpr double kConvergedChange = 1e-9;

/// Rotation angle plus the shift of the points' centre in units of l: free of units and frames.
double Change(const RigidTransform& a, const RigidTransform& b, const Eigen::Vector3d& center,
              double resolution_m) {
  return RotationAngle(a.rotation, b.rotation) + (a * center - b * center).norm() / resolution_m;
}

}  // namespace

GncWelschResult EstimateGncWelsch(const Correspondences& c, const RigidTransform& start,
                                  const GncWelschOptions& options) {
  const double l = options.resolution_m;
  GncWelschResult result;
  result.target_from_source = start;
  result.weights.assign(c.size(), 0.0);
  if (c.size() < 3) return result;

  std::vector<double> squared(c.size());
  SetSquaredResiduals(c, start, &squared);
  const double sigma_0 =
      std::max(3.0 * l, std::sqrt(*std::max_element(squared.begin(), squared.end())));
  const double ratio = std::pow(l / sigma_0, 1.0 / options.annealing_steps);
  double sigma = sigma_0;
  double sigma_min = l;
  bool adapted = false;
  result.status = GncWelschResult::Status::kMaxIterations;
  for (int it = 0; it < options.max_iterations; ++it) {
    if (it > 0 && it % 2 == 0) sigma = std::max(sigma_min, sigma * ratio);
    // With a margin: whether the geometric steps end at l or just above it is a matter of rounding.
    if (!adapted && sigma <= (1.0 + 1e-9) * l) {
      sigma_min = std::clamp(2.0 * MedianSd(squared, 3.0 * l), 0.5 * l, 1.5 * l);
      adapted = true;
      sigma = std::max(sigma, sigma_min);
    }
    for (std::size_t a = 0; a < c.size(); ++a) {
      result.weights[a] = std::exp(-squared[a] / (2.0 * sigma * sigma));
    }
    const auto fit = FitRigid(c, result.weights);
    if (!fit) {
      result.status = GncWelschResult::Status::kDegenerate;
      result.target_from_source = start;
      return result;
    }
    const double change = Change(*fit, result.target_from_source, c.source.front(), l);
    result.target_from_source = *fit;
    SetSquaredResiduals(c, *fit, &squared);
    result.iterations = it + 1;
    if (adapted && sigma <= sigma_min && change < kConvergedChange) {
      result.status = GncWelschResult::Status::kConverged;
      break;
    }
  }
  result.sigma_m = sigma;
  result.residual_sd_m = std::max(MedianSd(squared, 3.0 * sigma), 1e-3 * l);
  result.information = Information(c, result);
  return result;
}

}  // namespace backsight
