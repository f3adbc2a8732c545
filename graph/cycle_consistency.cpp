#include "graph/cycle_consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <utility>

namespace backsight {
namespace {

constexpr double kMedianOfChiSquared6 = 5.348;
constexpr double kTenthOfChiSquared6 = 2.204;

/// The links between two stations, and the neighbours of each.
class StationGraph {
 public:
  StationGraph(int stations, std::span<const PoseGraphLink> links)
      : neighbours_(static_cast<std::size_t>(stations)) {
    for (std::size_t l = 0; l < links.size(); ++l) {
      std::vector<int>& here = between_[Key(links[l].source, links[l].target)];
      if (here.empty()) {
        neighbours_[static_cast<std::size_t>(links[l].source)].push_back(links[l].target);
        neighbours_[static_cast<std::size_t>(links[l].target)].push_back(links[l].source);
      }
      here.push_back(static_cast<int>(l));
    }
    for (auto& list : neighbours_) std::sort(list.begin(), list.end());
  }
  const std::vector<int>& Of(int station) const {
    return neighbours_[static_cast<std::size_t>(station)];
  }
  /// Null where no link joins them.
  const std::vector<int>* Between(int a, int b) const {
    const auto found = between_.find(Key(a, b));
    return found == between_.end() ? nullptr : &found->second;
  }

 private:
  static std::pair<int, int> Key(int a, int b) { return std::minmax(a, b); }
  std::map<std::pair<int, int>, std::vector<int>> between_;
  std::vector<std::vector<int>> neighbours_;
};

/// All cycles over one loop of stations, one for each choice among rivals.
struct StationLoop {
  std::size_t first;  ///< its cycles in the list
  std::size_t last;
  int voter;  ///< link that this loop speaks for; -1: for all on it
};

class CycleFinder {
 public:
  CycleFinder(int stations, std::span<const PoseGraphLink> links)
      : links_(links), graph_(stations, links), on_triangle_(links.size(), 0) {
    for (const PoseGraphLink& link : links) covariances_.push_back(CovarianceOf(link.information));
    for (int a = 0; a < stations; ++a) FindTriangles(a);
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (on_triangle_[l] == 0) FindFours(static_cast<int>(l));
    }
  }
  std::vector<Cycle> cycles;
  std::vector<StationLoop> loops;

 private:
  void FindTriangles(int a) {
    for (const int b : graph_.Of(a)) {
      for (const int c : graph_.Of(a)) {
        if (b <= a || c <= b) continue;
        const std::vector<int>* across = graph_.Between(b, c);
        if (across == nullptr) continue;
        loops.push_back({cycles.size(), 0, -1});
        for (const int i : *graph_.Between(a, b)) {
          for (const int j : *across) {
            for (const int k : *graph_.Between(c, a)) {
              Add({i, j, k, -1}, a);
              for (const int l : {i, j, k}) on_triangle_[static_cast<std::size_t>(l)] = 1;
            }
          }
        }
        loops.back().last = cycles.size();
      }
    }
  }

  void FindFours(int link) {
    constexpr int kMostLoops = 100;
    int found = 0;
    const int a = links_[static_cast<std::size_t>(link)].source;
    const int b = links_[static_cast<std::size_t>(link)].target;
    for (const int c : graph_.Of(b)) {
      for (const int d : graph_.Of(a)) {
        if (c == a || d == b || c == d || found >= kMostLoops) continue;
        const std::vector<int>* across = graph_.Between(c, d);
        if (across == nullptr) continue;
        ++found;
        loops.push_back({cycles.size(), 0, link});
        for (const int j : *graph_.Between(b, c)) {
          for (const int k : *across) {
            for (const int m : *graph_.Between(d, a)) Add({link, j, k, m}, a);
          }
        }
        loops.back().last = cycles.size();
      }
    }
  }

  void Add(const std::array<int, 4>& links, int start) {
    Cycle cycle;
    cycle.links = links;
    cycle.start = start;
    const Misclosure misclosure = CloseLoop(links_, covariances_, cycle.Links(), start);
    cycle.rotation = misclosure.value.head<3>().norm();
    cycle.translation = misclosure.value.tail<3>().norm();
    cycle.squared_error = misclosure.SquaredError();
    cycles.push_back(cycle);
  }

  std::span<const PoseGraphLink> links_;
  StationGraph graph_;
  std::vector<Matrix6d> covariances_;
  std::vector<char> on_triangle_;
};

double Quantile(std::vector<double> values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// Of rivals over the same stations at most one combination is true: the best stands for all.
std::vector<double> BestOfEachLoop(const CycleFinder& finder) {
  std::vector<double> squared;
  for (const StationLoop& loop : finder.loops) {
    double best = finder.cycles[loop.first].squared_error;
    for (std::size_t c = loop.first; c < loop.last; ++c) {
      best = std::min(best, finder.cycles[c].squared_error);
    }
    squared.push_back(best);
  }
  return squared;
}

void CountSupport(std::span<const PoseGraphLink> links, const CycleFinder& finder, double limit,
                  std::vector<LinkSupport>* support) {
  for (const StationLoop& loop : finder.loops) {
    // Per link on the loop: 1 if a cycle through it closes, 2 if one of accepted links does.
    std::map<int, int> verdict;
    for (std::size_t c = loop.first; c < loop.last; ++c) {
      const Cycle& cycle = finder.cycles[c];
      const bool valid = cycle.squared_error <= limit;
      for (const int l : cycle.Links()) {
        if (loop.voter >= 0 && l != loop.voter) continue;
        const bool others_accepted = std::all_of(
            cycle.Links().begin(), cycle.Links().end(),
            [&](int k) { return k == l || !links[static_cast<std::size_t>(k)].doubtful; });
        int& best = verdict[l];
        if (valid) best = std::max(best, others_accepted ? 2 : 1);
      }
    }
    for (const auto& [link, best] : verdict) {
      LinkSupport& s = (*support)[static_cast<std::size_t>(link)];
      ++(best > 0 ? s.valid : s.invalid);
      if (best == 2) ++s.confirmed;
    }
  }
}

}  // namespace

double Misclosure::SquaredError() const { return value.dot(covariance.ldlt().solve(value)); }

Matrix6d CovarianceOf(const Matrix6d& information) {
  Vector6d least;
  least << 100.0, 100.0, 100.0, 1.0, 1.0, 1.0;
  Matrix6d held = 0.5 * (information + information.transpose());
  held.diagonal() += least;
  const Matrix6d covariance = held.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (covariance + covariance.transpose());
}

Misclosure CloseLoop(std::span<const PoseGraphLink> links, std::span<const Matrix6d> covariances,
                     std::span<const int> loop, int start) {
  RigidTransform product;
  Matrix6d covariance = Matrix6d::Zero();
  int here = start;
  for (const int l : loop) {
    const PoseGraphLink& link = links[static_cast<std::size_t>(l)];
    const bool forwards = link.target == here;  // here_from_next is target_from_source
    const RigidTransform motion =
        forwards ? link.target_from_source : link.target_from_source.Inverse();
    // The error of a motion gone through backwards sits behind its inverse.
    const Matrix6d adjoint = Adjoint(forwards ? product : product * motion);
    covariance += adjoint * covariances[static_cast<std::size_t>(l)] * adjoint.transpose();
    product = product * motion;
    here = forwards ? link.source : link.target;
  }
  Misclosure result;
  result.value = LocalDifference(product, RigidTransform{});
  const Matrix6d jacobian = LocalDifferenceJacobian(result.value);
  result.covariance = jacobian * covariance * jacobian.transpose();
  return result;
}

VarianceScale EstimateScale(const std::vector<double>& squared_errors,
                            const CycleOptions& options) {
  VarianceScale scale;
  scale.largest = squared_errors.size() >= options.many ? options.largest_factor_of_many
                                                        : options.largest_factor;
  if (squared_errors.empty()) return scale;
  const auto clamp = [&](double factor) { return std::clamp(factor, 1.0, scale.largest); };
  scale.factor = clamp(Quantile(squared_errors, 0.1) / kTenthOfChiSquared6);
  constexpr int kMaxRounds = 20;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<double> fitting;
    for (const double e : squared_errors) {
      if (e <= options.limit * scale.factor) fitting.push_back(e);
    }
    if (fitting.empty()) break;
    const double next = clamp(Quantile(fitting, 0.5) / kMedianOfChiSquared6);
    if (next == scale.factor) break;
    scale.factor = next;
  }
  return scale;
}

CycleStatistics CheckCycles(int stations, std::span<const PoseGraphLink> links,
                            const CycleOptions& options) {
  const CycleFinder finder(stations, links);
  CycleStatistics result;
  result.support.resize(links.size());
  result.scale = EstimateScale(BestOfEachLoop(finder), options);
  CountSupport(links, finder, options.limit * result.scale.factor, &result.support);
  result.cycles = finder.cycles;
  return result;
}

}  // namespace backsight
