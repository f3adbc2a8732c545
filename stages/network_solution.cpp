#include "stages/network_solution.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/graph_connectivity.h"
#include "graph/part_loops.h"
#include "graph/spanning_tree.h"
#include "graph/tree_loops.h"

namespace backsight {
namespace {

/// Squared error beyond which a link is taken as false. Well above chi^2's 99 % (16.81), because
/// real errors have longer tails than normal ones, and far below that of any false link.
constexpr double kGrossError = 100.0;

std::vector<PoseGraphLink> MakeLinks(std::span<const NetworkLink> links,
                                     const NetworkOptions& options) {
  std::vector<PoseGraphLink> result;
  for (const NetworkLink& link : links) {
    PoseGraphLink made;
    made.source = link.source;
    made.target = link.target;
    made.target_from_source = link.target_from_source;
    made.information = LinkCovariance(link, options).ldlt().solve(Matrix6d::Identity());
    made.confidence = link.confidence;
    made.pair = link.pair;
    made.score = link.score;
    made.doubtful = link.doubtful;
    made.credibility = link.credibility;
    result.push_back(made);
  }
  return result;
}

void ScaleInformation(double factor, std::vector<PoseGraphLink>* links) {
  for (PoseGraphLink& link : *links) link.information *= factor;
}

int Redundancy(const std::vector<int>& component, const std::vector<double>& weights) {
  if (component.empty()) return 0;
  const auto used = std::count_if(weights.begin(), weights.end(), [](double w) { return w > 0.0; });
  const int components = 1 + *std::max_element(component.begin(), component.end());
  return 6 * (static_cast<int>(used) - (static_cast<int>(component.size()) - components));
}

/// Variance factor from the squared residuals of an adjustment whose redundancy is `share` of its
/// observations. Residuals beyond chi^2's 99 % count as that (Winsor), lest a link on the verge of
/// being false excuse itself.
double EstimateFactorOfResiduals(std::vector<double> squared, double share) {
  constexpr double kMedianOfChiSquared6 = 5.348;
  constexpr double kLimit = 16.81;
  constexpr double kMeanBelowLimit = 5.975;  // of min(chi^2_6, kLimit)
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  double factor = *middle / (kMedianOfChiSquared6 * share);
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    for (const double e : squared) sum += std::min(e / share, kLimit * factor);
    factor = sum / (kMeanBelowLimit * static_cast<double>(squared.size()));
  }
  return factor;
}

/// Adjusts the links that the selection uses and returns the variance factor that this asks for.
double AdjustSelected(std::span<const PoseGraphLink> links, const LinkSelection& selection,
                      PoseGraphResult* poses) {
  std::vector<PoseGraphLink> used;
  const std::vector<char> use = selection.Used();
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (use[l] != 0) used.push_back(links[l]);
  }
  *poses = SolvePoseGraph(static_cast<int>(selection.survey_from_station.size()), used,
                          selection.survey_from_station, {.robust = false});
  poses->weights.assign(use.begin(), use.end());
  const int redundancy = Redundancy(poses->component, poses->weights);
  if (redundancy <= 0) return 0.0;
  std::vector<double> squared;
  squared.reserve(used.size());
  for (const PoseGraphLink& link : used) {
    squared.push_back(SquaredError(link, poses->survey_from_station));
  }
  return EstimateFactorOfResiduals(squared, redundancy / (6.0 * static_cast<double>(used.size())));
}

LinkSelection UseAll(int stations, std::span<const PoseGraphLink> links) {
  LinkSelection selection;
  selection.fate.assign(links.size(), LinkFate::kUsed);
  const PoseGraphResult start = SolvePoseGraph(stations, links, {}, {.robust = false});
  selection.survey_from_station = start.survey_from_station;
  selection.component = start.component;
  return selection;
}

/// Where no loop is shorter than five links, a corridor around a block: from the loops that links
/// close over a spanning forest.
std::vector<double> LongLoopErrors(int stations, std::span<const PoseGraphLink> links) {
  const SpanningForest forest = BuildSpanningForest(stations, links, {});
  std::vector<double> squared;
  for (const double error : TreeLoopErrors(stations, links, forest)) {
    if (error > 0.0 && std::isfinite(error)) squared.push_back(error);
  }
  return squared;
}

/// Selection and adjustment with the links' scale of error re-estimated until the selection stays.
LinkSelection SolveWithScale(int stations, const NetworkOptions& options,
                             const std::function<void()>& between,
                             std::vector<PoseGraphLink>* links, NetworkResult* result) {
  CycleStatistics cycles = CheckCycles(stations, *links, {});
  if (cycles.cycles.empty()) cycles.scale = EstimateScale(LongLoopErrors(stations, *links), {});
  result->support = cycles.support;
  double factor = cycles.scale.factor;
  result->cycle_sigma_factor = std::sqrt(factor);
  ScaleInformation(1.0 / factor, links);
  const std::vector<int> loops = CountPartLoops(stations, *links, kGrossError);
  for (std::size_t l = 0; l < links->size(); ++l) result->support[l].part_loops = loops[l];
  LinkSelection selection;
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<LinkFate> before = selection.fate;
    selection = options.robust ? SelectLinks(stations, *links, result->support,
                                             {.outlier_limit = kGrossError,
                                              .score_noise = options.score_noise,
                                              .between = between})
                               : UseAll(stations, *links);
    const double wanted = AdjustSelected(*links, selection, &result->poses);
    const double next = std::clamp(factor * wanted, 1.0, cycles.scale.largest);
    ScaleInformation(factor / next, links);
    result->poses.cost *= factor / next;
    factor = next;
    if (selection.fate == before) break;
  }
  result->sigma_factor = std::sqrt(factor);
  return selection;
}

void FillCovariances(std::span<const PoseGraphLink> links, NetworkResult* result) {
  const std::vector<RigidTransform>& poses = result->poses.survey_from_station;
  result->covariance = JointCovariance(links, result->poses.weights,
                                       FirstOfEachComponent(result->poses.component), poses);
  for (std::size_t s = 0; s < poses.size(); ++s) {
    const auto i = static_cast<Eigen::Index>(6 * s);
    result->poses.covariance.emplace_back(result->covariance.block<6, 6>(i, i));
  }
  for (const PoseGraphLink& link : links) {
    const bool together = result->poses.component[static_cast<std::size_t>(link.source)] ==
                          result->poses.component[static_cast<std::size_t>(link.target)];
    result->link_covariance.push_back(
        together ? RelativeCovariance(result->covariance, link.source, link.target,
                                      poses[static_cast<std::size_t>(link.target)])
                 : Matrix6d(Matrix6d::Zero()));
  }
  result->weakest = FindWeakestDirection(result->covariance, links, poses);
}

void FillClosures(int stations, std::span<const PoseGraphLink> links, NetworkResult* result) {
  std::vector<PoseGraphLink> used;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (result->poses.weights[l] > 0.0) used.push_back(links[l]);
  }
  for (const Cycle& cycle : CheckCycles(stations, used, {}).cycles) {
    if (cycle.links[3] >= 0) continue;
    const PoseGraphLink& across = used[static_cast<std::size_t>(cycle.links[1])];
    result->closures.push_back({cycle.start, std::min(across.source, across.target),
                                std::max(across.source, across.target),
                                cycle.rotation * 180.0 / std::numbers::pi, cycle.translation,
                                cycle.squared_error});
  }
}

}  // namespace

Matrix6d LinkCovariance(const NetworkLink& link, const NetworkOptions& options) {
  const double rotation = options.floor_rotation_deg * std::numbers::pi / 180.0;
  Matrix6d covariance = CovarianceOf(link.information);
  covariance.topLeftCorner<3, 3>().diagonal().array() += rotation * rotation;
  covariance.bottomRightCorner<3, 3>().diagonal().array() +=
      options.floor_translation_m * options.floor_translation_m;
  return covariance;
}

double ResidualInSigmas(const NetworkLink& link, const RigidTransform& target_from_source,
                        const NetworkOptions& options) {
  const Vector6d residual = LocalDifference(target_from_source, link.target_from_source);
  const double squared = residual.dot(LinkCovariance(link, options).ldlt().solve(residual));
  return std::sqrt(squared / 6.0);
}

void VisitOptions(OptionVisitor& visitor, NetworkOptions& options) {
  visitor.Flag("robust", options.robust, "seek and remove false links, choose among rival ones");
  visitor.Real("floor_rotation_deg", options.floor_rotation_deg, "deg", 0.0, 1.0,
               "systematic rotation error that no link is better than");
  visitor.Real("floor_translation_m", options.floor_translation_m, "m", 0.0, 1.0,
               "systematic translation error that no link is better than");
  visitor.Real("score_noise", options.score_noise, "", 1e-6, 1.0,
               "standard deviation of the score by which rival motions of a pair are compared");
}

LinkSelection ChooseLinks(int stations, std::span<const NetworkLink> links,
                          const NetworkOptions& options, const std::function<void()>& between) {
  NetworkResult unused;
  std::vector<PoseGraphLink> scaled = MakeLinks(links, options);
  return SolveWithScale(stations, options, between, &scaled, &unused);
}

NetworkResult SolveNetwork(int stations, std::span<const NetworkLink> links,
                           const NetworkOptions& options, const std::function<void()>& between) {
  NetworkResult result;
  std::vector<PoseGraphLink> scaled = MakeLinks(links, options);
  const LinkSelection selection = SolveWithScale(stations, options, between, &scaled, &result);
  result.fate = selection.fate;
  result.ambiguities = selection.ambiguities;
  result.readmitted = selection.readmitted;
  result.moves = selection.moves;
  result.redundancy = Redundancy(result.poses.component, result.poses.weights);
  const std::vector<char> used = selection.Used();
  result.removed = static_cast<int>(std::count(used.begin(), used.end(), 0));
  const std::vector<char> bridges = FindBridges(stations, scaled, used);
  for (std::size_t l = 0; l < scaled.size(); ++l) {
    result.loop_controlled.push_back(used[l] != 0 && bridges[l] == 0);
  }
  FillCovariances(scaled, &result);
  FillClosures(stations, scaled, &result);
  return result;
}

}  // namespace backsight
