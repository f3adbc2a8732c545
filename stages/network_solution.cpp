#include "stages/network_solution.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace backsight {
namespace {

constexpr double kMedianOfChiSquared6 = 5.348;
/// Squared error beyond which a link is taken as false. Well above chi^2's 99 % (16.81), because
/// real errors have longer tails than normal ones, and far below that of any false link.
constexpr double kGrossError = 100.0;
/// More disagreement than this is no longer noise, but false links.
constexpr double kLargestVarianceFactor = 25.0;

/// Covariance of a link: what the registration claims, held above the systematic floor.
Matrix6d LinkCovariance(const NetworkLink& link, const NetworkOptions& options) {
  const Matrix6d formal = link.information.ldlt().solve(Matrix6d::Identity());
  const double rotation = options.floor_rotation_deg * std::numbers::pi / 180.0;
  Matrix6d covariance = 0.5 * (formal + formal.transpose());
  covariance.topLeftCorner<3, 3>().diagonal().array() += rotation * rotation;
  covariance.bottomRightCorner<3, 3>().diagonal().array() +=
      options.floor_translation_m * options.floor_translation_m;
  return covariance;
}

std::vector<PoseGraphLink> MakeLinks(std::span<const NetworkLink> links,
                                     const NetworkOptions& options, double variance_factor) {
  std::vector<PoseGraphLink> result;
  for (const NetworkLink& link : links) {
    const Matrix6d covariance = variance_factor * LinkCovariance(link, options);
    result.push_back({link.source, link.target, link.target_from_source,
                      covariance.ldlt().solve(Matrix6d::Identity()), link.confidence});
  }
  return result;
}

int Redundancy(const PoseGraphResult& poses) {
  int used = 0;
  for (const double weight : poses.weights) used += weight > 0.0 ? 1 : 0;
  const int components = 1 + *std::max_element(poses.component.begin(), poses.component.end());
  return 6 * (used - (static_cast<int>(poses.component.size()) - components));
}

/// Variance factor from the median squared error of the links: half of them may be false.
double EstimateVarianceFactor(std::span<const PoseGraphLink> links, const PoseGraphResult& poses) {
  const int redundancy = Redundancy(poses);
  if (redundancy <= 0) return 1.0;
  std::vector<double> squared;
  for (const PoseGraphLink& link : links) {
    const Vector6d r =
        LinkResidual(link, poses.survey_from_station[static_cast<std::size_t>(link.source)],
                     poses.survey_from_station[static_cast<std::size_t>(link.target)]);
    squared.push_back(r.dot(link.information * r));
  }
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  const double share = static_cast<double>(redundancy) / (6.0 * static_cast<double>(links.size()));
  return *middle / (kMedianOfChiSquared6 * share);
}

/// A link lies on a loop if its ends stay connected without it.
std::vector<bool> FindLoopControl(int stations, std::span<const PoseGraphLink> links,
                                  const std::vector<double>& weights) {
  std::vector<bool> controlled;
  for (std::size_t l = 0; l < links.size(); ++l) {
    std::vector<int> label(static_cast<std::size_t>(stations));
    for (std::size_t s = 0; s < label.size(); ++s) label[s] = static_cast<int>(s);
    for (std::size_t k = 0; k < links.size(); ++k) {
      if (k == l || weights[k] <= 0.0) continue;
      const int from = label[static_cast<std::size_t>(links[k].source)];
      const int to = label[static_cast<std::size_t>(links[k].target)];
      std::replace(label.begin(), label.end(), from, to);
    }
    controlled.push_back(weights[l] > 0.0 && label[static_cast<std::size_t>(links[l].source)] ==
                                                 label[static_cast<std::size_t>(links[l].target)]);
  }
  return controlled;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, NetworkOptions& options) {
  visitor.Flag("robust", options.robust, "seek and remove false links");
  visitor.Real("floor_rotation_deg", options.floor_rotation_deg, "deg", 0.0, 1.0,
               "systematic rotation error that no link is better than");
  visitor.Real("floor_translation_m", options.floor_translation_m, "m", 0.0, 1.0,
               "systematic translation error that no link is better than");
}

NetworkResult SolveNetwork(int stations, std::span<const NetworkLink> links,
                           const NetworkOptions& options) {
  NetworkResult result;
  std::vector<PoseGraphLink> weighted = MakeLinks(links, options, 1.0);
  double variance_factor = 1.0;
  if (!links.empty()) {
    // The least-squares fit spreads gross errors over all links; one robust pass takes them out
    // before the scale is judged for good.
    for (const bool robust : {false, options.robust}) {
      const PoseGraphResult trial =
          SolvePoseGraph(stations, weighted, {.robust = robust, .outlier_quantile = kGrossError});
      variance_factor = std::clamp(variance_factor * EstimateVarianceFactor(weighted, trial), 1.0,
                                   kLargestVarianceFactor);
      weighted = MakeLinks(links, options, variance_factor);
    }
  }
  result.poses = SolvePoseGraph(stations, weighted,
                                {.robust = options.robust, .outlier_quantile = kGrossError});
  result.sigma_factor = std::sqrt(variance_factor);
  result.redundancy = Redundancy(result.poses);
  result.loop_controlled = FindLoopControl(stations, weighted, result.poses.weights);
  for (const PoseGraphLink& link : weighted) {
    result.residuals.push_back(
        LinkResidual(link, result.poses.survey_from_station[static_cast<std::size_t>(link.source)],
                     result.poses.survey_from_station[static_cast<std::size_t>(link.target)]));
  }
  return result;
}

}  // namespace backsight
