#include "stages/placement_check.h"

#include <algorithm>

namespace backsight {
namespace {

/// Counts of blocks, one way or both.
struct Views {
  double seen_through = 0.0;
  int in_view = 0;

  void Add(const Views& other) {
    seen_through += other.seen_through;
    in_view += other.in_view;
  }
  double conflict() const {
    return in_view > 0 ? seen_through / static_cast<double>(in_view) : 0.0;
  }
};

struct ComparedPair {
  int a = 0;
  int b = 0;
  Views of_a;  ///< a's surface as b's scanner saw it
  Views of_b;
};

/// Range that holds 95 % of a station's voxels.
double ReachOf(const StationModel& model) {
  std::vector<double> ranges;
  ranges.reserve(model.leaves.size());
  for (const Eigen::Vector3d& mean : model.leaves.means()) ranges.push_back(mean.norm());
  if (ranges.empty()) return 0.0;
  const auto place = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 95 / 100);
  std::nth_element(ranges.begin(), place, ranges.end());
  return *place;
}

std::vector<ComparedPair> NeighborPairs(const PlacementCheckInput& input,
                                        const std::vector<double>& reach) {
  std::vector<ComparedPair> pairs;
  for (std::size_t a = 0; a < input.stations.size(); ++a) {
    for (std::size_t b = a + 1; b < input.stations.size(); ++b) {
      if (input.stations[a] == nullptr || input.stations[b] == nullptr) continue;
      if (input.component[a] != input.component[b] || input.component[a] < 0) continue;
      const double distance =
          (input.survey_from_station[a].translation - input.survey_from_station[b].translation)
              .norm();
      if (distance > std::max(reach[a], reach[b])) continue;
      ComparedPair pair;
      pair.a = static_cast<int>(a);
      pair.b = static_cast<int>(b);
      pairs.push_back(pair);
    }
  }
  return pairs;
}

/// What `viewer` says of the surfaces that `moved` measured.
Views Look(const PlacementCheckInput& input, const std::vector<CloudSample>& samples, int moved,
           int viewer) {
  const auto m = static_cast<std::size_t>(moved);
  const auto v = static_cast<std::size_t>(viewer);
  const RigidTransform viewer_from_moved =
      input.survey_from_station[v].Inverse() * input.survey_from_station[m];
  const CloudAgreement agreement =
      CompareClouds(*input.stations[m], samples[m], *input.stations[v], *input.indices[v],
                    viewer_from_moved, input.stations[v]->model.resolution_m());
  Views views;
  views.in_view = agreement.blocks_in_view;
  views.seen_through = agreement.conflict.value * agreement.blocks_in_view;
  return views;
}

/// Which stations still hang together with `start` when `bridge` is left out.
std::vector<char> SideOf(const PlacementCheckInput& input, std::size_t bridge, int start) {
  std::vector<char> reached(input.stations.size(), 0);
  reached[static_cast<std::size_t>(start)] = 1;
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t l = 0; l < input.links.size(); ++l) {
      if (l == bridge) continue;
      char& source = reached[static_cast<std::size_t>(input.links[l].source)];
      char& target = reached[static_cast<std::size_t>(input.links[l].target)];
      if (source == target) continue;
      source = target = 1;
      grown = true;
    }
  }
  return reached;
}

/// All that the stations on the two sides of a bridge say of each other.
Views AcrossBridge(const PlacementCheckInput& input, const std::vector<ComparedPair>& pairs,
                   std::size_t bridge) {
  const std::vector<char> side = SideOf(input, bridge, input.links[bridge].source);
  Views views;
  for (const ComparedPair& pair : pairs) {
    if (side[static_cast<std::size_t>(pair.a)] == side[static_cast<std::size_t>(pair.b)]) continue;
    views.Add(pair.of_a);
    views.Add(pair.of_b);
  }
  return views;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, PlacementCheckOptions& options) {
  visitor.Real("max_conflict", options.max_conflict, "1", 0.0, 1.0,
               "largest share of the blocks in view that a scanner may have seen through, between "
               "placed stations and across a bridge");
  visitor.Integer("min_blocks", options.min_blocks, "1", 1, 100000,
                  "fewest blocks in view that count as evidence");
}

PlacementCheckResult CheckPlacements(const PlacementCheckInput& input,
                                     const PlacementCheckOptions& options,
                                     const ExecutionContext& context) {
  constexpr std::size_t kSample = 4000;
  const std::size_t stations = input.stations.size();
  std::vector<double> reach(stations, 0.0);
  std::vector<CloudSample> samples(stations);
  context.ParallelFor(stations, [&](std::size_t s) {
    if (input.stations[s] == nullptr) return;
    reach[s] = ReachOf(input.stations[s]->model);
    samples[s] = SampleCloud(input.stations[s]->model, kSample);
  });
  std::vector<ComparedPair> pairs = NeighborPairs(input, reach);
  context.ParallelFor(pairs.size(), [&](std::size_t i) {
    context.CheckStop();
    ComparedPair& pair = pairs[i];
    pair.of_a = Look(input, samples, pair.a, pair.b);
    pair.of_b = Look(input, samples, pair.b, pair.a);
  });

  PlacementCheckResult result;
  result.pairs_compared = static_cast<int>(pairs.size());
  for (const ComparedPair& pair : pairs) {
    for (const Views& views : {pair.of_a, pair.of_b}) {
      if (views.in_view < options.min_blocks || views.conflict() <= options.max_conflict) continue;
      result.conflicts.push_back({pair.a, pair.b, views.conflict(), views.in_view});
      break;
    }
  }
  double worst = options.max_conflict;
  for (std::size_t l = 0; l < input.links.size(); ++l) {
    if (input.links[l].loop_controlled) continue;
    const Views views = AcrossBridge(input, pairs, l);
    if (views.in_view >= options.min_blocks && views.conflict() > worst) {
      worst = views.conflict();
      result.refuted_bridge = static_cast<int>(l);
    }
  }
  return result;
}

}  // namespace backsight
