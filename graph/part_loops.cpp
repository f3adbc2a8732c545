#include "graph/part_loops.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "graph/cycle_consistency.h"
#include "graph/rival_placements.h"
#include "graph/spanning_tree.h"
#include "graph/tree_loops.h"

namespace backsight {
namespace {

std::size_t Slot(int k) { return static_cast<std::size_t>(k); }

double LargestEigenvalue(const Eigen::Matrix3d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues()[2];
}

bool KnowsItsMotion(const PoseGraphLink& link) {
  constexpr double kShift = 0.3;                  // m
  constexpr double kTurn = 0.017453292519943295;  // 1 deg
  const Matrix6d covariance = CovarianceOf(link.information);
  return LargestEigenvalue(covariance.topLeftCorner<3, 3>()) <= kTurn * kTurn &&
         LargestEigenvalue(covariance.bottomRightCorner<3, 3>()) <= kShift * kShift;
}

/// What accepted links hold together, with the stations' poses and errors in each part's frame.
struct Parts {
  SpanningForest forest;
  std::vector<Matrix6d> covariance;

  Parts(int stations, std::span<const PoseGraphLink> links) {
    std::vector<char> accepted;
    for (const PoseGraphLink& link : links) accepted.push_back(link.doubtful ? 0 : 1);
    forest = BuildSpanningForest(stations, links, accepted);
    covariance = TreeCovariances(stations, links, forest);
  }

  int Of(int station) const { return forest.component[Slot(station)]; }

  /// The motion between the parts that a link between their stations asks for.
  PoseGraphLink Between(const PoseGraphLink& link) const {
    const RigidTransform& part_from_target = forest.survey_from_station[Slot(link.target)];
    const RigidTransform& part_from_source = forest.survey_from_station[Slot(link.source)];
    PoseGraphLink between = link;
    between.source = Of(link.source);
    between.target = Of(link.target);
    between.target_from_source =
        part_from_target * link.target_from_source * part_from_source.Inverse();
    const Matrix6d of_link = Adjoint(part_from_target);
    const Matrix6d of_source = Adjoint(between.target_from_source);
    const Matrix6d sum = covariance[Slot(link.target)] +
                         of_link * CovarianceOf(link.information) * of_link.transpose() +
                         of_source * covariance[Slot(link.source)] * of_source.transpose();
    const Matrix6d information = sum.ldlt().solve(Matrix6d::Identity());
    between.information = 0.5 * (information + information.transpose());
    return between;
  }
};

/// For each link the pairs of other stations whose links close a loop of two parts with it.
std::vector<int> CountParallels(std::span<const PoseGraphLink> between,
                                std::span<const std::pair<int, int>> stations, double limit) {
  std::vector<Matrix6d> covariances;
  for (const PoseGraphLink& link : between) covariances.push_back(CovarianceOf(link.information));
  std::vector<std::set<std::pair<int, int>>> agreeing(between.size());
  for (std::size_t a = 0; a < between.size(); ++a) {
    for (std::size_t b = a + 1; b < between.size(); ++b) {
      if (stations[a] == stations[b] || std::minmax(between[a].source, between[a].target) !=
                                            std::minmax(between[b].source, between[b].target)) {
        continue;
      }
      const std::array<int, 2> loop = {static_cast<int>(a), static_cast<int>(b)};
      if (CloseLoop(between, covariances, loop, between[a].target).SquaredError() > limit) continue;
      agreeing[a].insert(stations[b]);
      agreeing[b].insert(stations[a]);
    }
  }
  std::vector<int> count;
  count.reserve(agreeing.size());
  for (const auto& pairs : agreeing) count.push_back(static_cast<int>(pairs.size()));
  return count;
}

/// Of the links between each two parts the few with most support, lest the combinations of many
/// explode: links that agree close the same loops.
std::vector<std::size_t> Representatives(std::span<const PoseGraphLink> between,
                                         std::span<const int> parallels) {
  constexpr std::size_t kMost = 6;
  std::map<std::pair<int, int>, std::vector<std::size_t>> of_parts;
  for (std::size_t k = 0; k < between.size(); ++k) {
    of_parts[std::minmax(between[k].source, between[k].target)].push_back(k);
  }
  std::vector<std::size_t> chosen;
  for (auto& [parts, own] : of_parts) {
    std::stable_sort(own.begin(), own.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(parallels[a], between[a].confidence) >
             std::pair(parallels[b], between[b].confidence);
    });
    own.resize(std::min(own.size(), kMost));
    chosen.insert(chosen.end(), own.begin(), own.end());
  }
  return chosen;
}

}  // namespace

std::vector<int> CountPartLoops(int stations, std::span<const PoseGraphLink> links, double limit) {
  const Parts parts(stations, links);
  std::vector<std::size_t> asked;
  std::vector<PoseGraphLink> between;
  std::vector<std::pair<int, int>> ends;
  for (std::size_t l = 0; l < links.size(); ++l) {
    const PoseGraphLink& link = links[l];
    if (!link.doubtful || parts.Of(link.source) == parts.Of(link.target)) continue;
    if (link.credibility < kLeastCredibility || !KnowsItsMotion(link)) continue;
    asked.push_back(l);
    between.push_back(parts.Between(link));
    ends.emplace_back(std::minmax(link.source, link.target));
  }
  const std::vector<int> parallels = CountParallels(between, ends, limit);
  const std::vector<std::size_t> chosen = Representatives(between, parallels);
  std::vector<PoseGraphLink> few;
  few.reserve(chosen.size());
  for (const std::size_t k : chosen) few.push_back(between[k]);
  // The links' errors are of the right scale already.
  const CycleOptions options{.limit = limit, .largest_factor = 1.0, .largest_factor_of_many = 1.0};
  const CycleStatistics cycles = CheckCycles(stations, few, options);
  std::vector<int> loops(links.size(), 0);
  for (std::size_t k = 0; k < asked.size(); ++k) loops[asked[k]] = parallels[k];
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    loops[asked[chosen[i]]] += cycles.support[i].valid;
  }
  return loops;
}

}  // namespace backsight
