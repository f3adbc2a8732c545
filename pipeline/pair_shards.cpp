#include "pipeline/pair_shards.h"

#include <algorithm>
#include <atomic>
#include <set>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_pipeline.h"
#include "pipeline/station_pipeline.h"

namespace backsight {
namespace {

constexpr int kMostShards = 200;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// All stations as the project has them, nothing of them loaded.
std::vector<Station> Unloaded(const std::vector<StationSpec>& specs) {
  std::vector<Station> stations(specs.size());
  for (std::size_t s = 0; s < specs.size(); ++s) stations[s].spec = specs[s];
  return stations;
}

/// Every pair that an exhaustive campaign registers if all its scans can be used.
std::vector<Pair> AllPairs(const SurveyProject& project, const SurveyOptions& options) {
  const auto count = static_cast<int>(project.stations.size());
  if (!IsExhaustive(count, options.pair_selection)) return {};
  return PlanPairs(Unloaded(project.stations), project.pairs);
}

/// Stations keep their places, so that pairs are the same as in the whole run.
std::vector<Station> LoadSome(const std::vector<StationSpec>& specs, const std::set<int>& wanted,
                              const SurveyOptions& options, const ExecutionContext& context,
                              const ArtifactStore& store) {
  std::vector<StationSpec> some;
  for (const int s : wanted) some.push_back(specs[At(s)]);
  std::vector<Station> loaded = LoadStations(some, options, context, store);
  std::vector<Station> stations = Unloaded(specs);
  std::size_t next = 0;
  for (const int s : wanted) stations[At(s)] = std::move(loaded[next++]);
  return stations;
}

}  // namespace

int CountPairShards(const SurveyProject& project, const SurveyOptions& options) {
  return std::min(static_cast<int>(AllPairs(project, options).size()), kMostShards);
}

int RegisterPairShard(const SurveyProject& project, const SurveyOptions& options,
                      const PairShard& shard, const ExecutionContext& context,
                      const ArtifactStore& store) {
  const std::vector<Pair> all = AllPairs(project, options);
  std::vector<Pair> pairs;
  std::set<int> wanted;
  for (std::size_t i = At(shard.index); i < all.size(); i += At(shard.count)) {
    pairs.push_back(all[i]);
    wanted.insert({all[i].source, all[i].target});
  }
  const std::vector<Station> stations = LoadSome(project.stations, wanted, options, context, store);
  const PairUnits units(stations, options, context, store, project.resources.pair_limit_s);
  std::atomic<std::size_t> done = 0;
  std::atomic<int> failed = 0;
  context.Progress("pairs", 0, pairs.size());
  context.ParallelFor(pairs.size(), [&](std::size_t i) {
    context.CheckStop();
    Pair& pair = pairs[i];
    const bool usable = stations[At(pair.source)].usable() && stations[At(pair.target)].usable();
    if (usable) units.Register(PairMethod::kFull, std::nullopt, &pair);
    if (!usable || !pair.fault.empty()) ++failed;
    context.Progress("pairs", ++done, pairs.size());
  });
  return failed;
}

}  // namespace backsight
