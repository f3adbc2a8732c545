#include "pipeline/pair_shards.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <set>

#include "core/error.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/artifacts/pair_artifact.h"
#include "pipeline/artifacts/pair_units.h"
#include "pipeline/grouped_work.h"
#include "pipeline/pair_pipeline.h"
#include "pipeline/station_pipeline.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, PairTask& task) {
  archive(task.source, task.target, task.method, task.predicted, task.before, task.digest);
}

namespace {

constexpr const char* kBatchName = "slurm/batch";

std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// Every pair that an exhaustive campaign registers if all its scans can be used.
std::vector<Pair> AllPairs(const SurveyProject& project, const SurveyOptions& options) {
  const auto count = static_cast<int>(project.stations.size());
  if (!IsExhaustive(count, options.pair_selection)) return {};
  return PlanPairs(ListStations(project.stations), project.pairs);
}

/// Stations keep their places, so that pairs are the same as in the whole run.
std::vector<Station> LoadSome(const std::vector<StationSpec>& specs, const std::set<int>& wanted,
                              const SurveyOptions& options, const ExecutionContext& context,
                              const ArtifactStore& store) {
  std::vector<StationSpec> some;
  some.reserve(wanted.size());
  for (const int s : wanted) some.push_back(specs[At(s)]);
  std::vector<Station> loaded = LoadStations(some, options, context, store);
  std::vector<Station> stations = ListStations(specs);
  std::size_t next = 0;
  for (const int s : wanted) stations[At(s)] = std::move(loaded[next++]);
  return stations;
}

std::vector<PairTask> ShareOf(const std::vector<PairTask>& tasks, const PairShard& shard) {
  std::vector<PairTask> share;
  for (std::size_t i = At(shard.index); i < tasks.size(); i += At(shard.count)) {
    share.push_back(tasks[i]);
  }
  return share;
}

/// How an attempt ended.
enum class AttemptEnd : char { kStored, kFailed, kShortOfMemory };

AttemptEnd MakeAttempt(const PairUnits& units, const PairTask& task) {
  units.context().CheckStop();
  const std::vector<Station>& stations = units.stations();
  if (!stations[At(task.source)].usable() || !stations[At(task.target)].usable()) {
    return AttemptEnd::kFailed;
  }
  Pair pair;
  pair.source = task.source;
  pair.target = task.target;
  RestorePair(task.before, &pair);
  pair.digest = task.digest;
  if (units.Register(task.method, task.predicted, &pair)) return AttemptEnd::kStored;
  return pair.short_of_memory ? AttemptEnd::kShortOfMemory : AttemptEnd::kFailed;
}

/// Attempts that found no memory beside others, one after the other.
void RetryAlone(const PairUnits& units, const std::vector<PairTask>& tasks,
                std::vector<AttemptEnd>* ends) {
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    AttemptEnd& end = (*ends)[i];
    if (end != AttemptEnd::kShortOfMemory) continue;
    end = MakeAttempt(units, tasks[i]);
    if (end != AttemptEnd::kShortOfMemory) continue;
    const auto id = [&](int station) { return units.stations()[At(station)].spec.id; };
    units.context().Warning(
        fmt::format("pair {} {}: {}", id(tasks[i].source), id(tasks[i].target), kShortOfMemory));
  }
}

/// Returns how many failed.
int MakeAttempts(const std::vector<PairTask>& tasks, const SurveyProject& project,
                 const SurveyOptions& options, const ExecutionContext& context,
                 const ArtifactStore& store) {
  std::set<int> wanted;
  for (const PairTask& task : tasks) wanted.insert({task.source, task.target});
  const std::vector<Station> stations = LoadSome(project.stations, wanted, options, context, store);
  const PairUnits units(stations, options, context, store, project.resources.pair_limit_s);
  std::atomic<std::size_t> done = 0;
  std::vector<AttemptEnd> ends(tasks.size());
  context.Progress("pairs", 0, tasks.size());
  std::vector<GroupedWork> works;
  works.reserve(tasks.size());
  for (const PairTask& task : tasks) works.push_back({task.target, 1.0});
  LargestGroupsFirst(works, context, [&](std::size_t i) {
    ends[i] = MakeAttempt(units, tasks[i]);
    context.Progress("pairs", ++done, tasks.size());
  });
  RetryAlone(units, tasks, &ends);
  return static_cast<int>(std::count_if(ends.begin(), ends.end(),
                                        [](AttemptEnd end) { return end != AttemptEnd::kStored; }));
}

ArtifactKey BatchKey(const SurveyProject& project, const SurveyOptions& options,
                     const ExecutionContext& context) {
  ArtifactKey key = StageKey({options, context.seed()}, "batch", {});
  for (const StationSpec& spec : project.stations) key.Add("station", spec.id);
  return key;
}

}  // namespace

int CountPairShards(const SurveyProject& project, const SurveyOptions& options) {
  return std::min(static_cast<int>(AllPairs(project, options).size()), kMostPairShards);
}

int RegisterPairShard(const SurveyProject& project, const SurveyOptions& options,
                      const PairShard& shard, const ExecutionContext& context,
                      const ArtifactStore& store) {
  std::vector<PairTask> tasks;
  for (const Pair& pair : AllPairs(project, options)) {
    tasks.push_back({pair.source, pair.target, PairMethod::kFull, {}, PairBytes(Pair()), ""});
  }
  return MakeAttempts(ShareOf(tasks, shard), project, options, context, store);
}

void StoreBatch(const std::vector<PairTask>& batch, const SurveyProject& project,
                const SurveyOptions& options, const ExecutionContext& context,
                const ArtifactStore& store) {
  store.Store(kBatchName, BatchKey(project, options, context), ToBytes(batch));
}

int RegisterBatchShard(const SurveyProject& project, const SurveyOptions& options,
                       const PairShard& shard, const ExecutionContext& context,
                       const ArtifactStore& store) {
  const auto batch = LoadArtifact(store, kBatchName, BatchKey(project, options, context),
                                  FromBytes<std::vector<PairTask>>);
  if (!batch) {
    throw InputError({store.PathOf(kBatchName), "no pairs of this project and program", "",
                      "start the run again"});
  }
  return MakeAttempts(ShareOf(*batch, shard), project, options, context, store);
}

}  // namespace backsight
