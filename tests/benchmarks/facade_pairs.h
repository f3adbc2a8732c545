#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <memory>
#include <vector>

#include "graph/edge_consensus.h"
#include "graph/gnc_welsch.h"
#include "graph/plane_tree.h"
#include "pipeline/pair_pipeline.h"

namespace backsight {

inline constexpr double kResolution = 0.1;

/// A pair up to its coarse motion.
struct FacadePair {
  const Station* source = nullptr;
  const Station* target = nullptr;
  std::shared_ptr<const PlaneTree> target_planes;
  Pair pair;
  Correspondences rows;
  Correspondences reliable;
  RigidTransform coarse;
  Correspondences inliers;
  RigidTransform truth;  ///< target_from_source, as given
};

/// The pairs of ETH Facade ($BACKSIGHT_DATA/eth_facade); none where the data is absent.
struct Facade {
  Facade();
  std::vector<Station> stations;
  std::vector<FacadePair> pairs;
};
const Facade& TheFacade();

/// The steps of the coarse registration, as it calls them.
Correspondences Reliable(const Correspondences& c, const ExecutionContext& context);
std::vector<EdgeHypothesis> Hypotheses(const Correspondences& c, const ExecutionContext& context);
Correspondences Inliers(const Correspondences& c, const RigidTransform& motion);
GncWelschResult Estimate(const Correspondences& inliers, const RigidTransform& motion);

/// Counters: how far the pairs' motions are from the given truth, median and largest.
void ReportErrors(const std::function<RigidTransform(const FacadePair&)>& motion_of,
                  benchmark::State* state);

/// What `body(pair)` takes, over the pairs in turn; skips where the data is absent. Counters: the
/// median and the largest wall time, and the median CPU time of this process.
template <class Body>
void OverPairs(benchmark::State& state, Body body) {
  if (TheFacade().pairs.empty()) {
    state.SkipWithError("no BACKSIGHT_DATA/eth_facade");
    return;
  }
  std::vector<double> seconds, cpu_seconds;
  std::size_t next = 0;
  for (auto _ : state) {
    const FacadePair& pair = TheFacade().pairs[next++ % TheFacade().pairs.size()];
    const std::clock_t cpu_begin = std::clock();
    const auto begin = std::chrono::steady_clock::now();
    body(pair);
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    cpu_seconds.push_back(static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC);
    state.SetIterationTime(seconds.back());
  }
  std::sort(seconds.begin(), seconds.end());
  std::sort(cpu_seconds.begin(), cpu_seconds.end());
  state.counters["median_ms"] = 1e3 * seconds[seconds.size() / 2];
  state.counters["max_ms"] = 1e3 * seconds.back();
  state.counters["median_cpu_ms"] = 1e3 * cpu_seconds[cpu_seconds.size() / 2];
}

}  // namespace backsight
