#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <new>

#include "core/error.h"
#include "io/artifact_store.h"
#include "pipeline/commands/commands.h"
#include "pipeline/pair_shards.h"
#include "pipeline/resource_budget.h"
#include "pipeline/run_events.h"
#include "pipeline/slurm_client.h"
#include "pipeline/slurm_executor.h"
#include "pipeline/station_pipeline.h"
#include "pipeline/stop_signal.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

SlurmSubmission NextSubmission(const WorkArguments& arguments, double memory_gb) {
  SlurmSubmission submission;
  submission.project = arguments.folders.project;
  submission.out = arguments.folders.OutDirectory();
  submission.work = arguments.folders.WorkDirectory();
  submission.threads = arguments.threads;
  submission.memory_gb = memory_gb;
  submission.options = arguments.slurm_options;
  return submission;
}

/// Has the next batch of a growing discovery registered by other jobs. Where the last one brought
/// nothing, what is missing cannot be had that way, and the final run is left to it.
void Coordinate(const WorkArguments& arguments, const ExecutionContext& context,
                const SurveyProject& project, const SurveyOptions& options,
                const ArtifactStore& store, EventSink* events) {
  const SlurmSubmission submission =
      NextSubmission(arguments, arguments.memory_gb.value_or(project.resources.memory_gb));
  // Half a round would set the final job free: it is submitted whole, whatever stop is requested.
  const auto steady = [&] { return ExecutionContext(1, kRunSeed, events); };
  {
    const FolderLock lock = LockWhenFree(store.folder(), context);
    if (!JobsToContinue(submission, OwnJob(), steady())) return;
  }
  const std::vector<Station> stations = LoadStations(project.stations, options, context, store);
  const PairUnits units(stations, options, context, store);
  const DiscoveryFrontier frontier = FindFrontier(units, project.pairs);
  const auto missing = static_cast<int>(frontier.missing.size());
  context.Info(fmt::format("{} attempts at pairs are stored, {} are needed next", frontier.done,
                           frontier.missing.size()));
  if (missing == 0 || arguments.done == frontier.done) return;
  const FolderLock lock = LockWhenFree(store.folder(), context);
  const auto jobs = JobsToContinue(submission, OwnJob(), steady());
  if (!jobs) return;  // they were cancelled meanwhile
  StoreBatch(frontier.missing, project, options, context, store);
  SubmitRound(submission, *jobs, std::min(missing, kMostPairShards), frontier.done, steady());
}

std::string PartOf(const WorkArguments& arguments) {
  if (arguments.coordinate) return "choice of pairs";
  return arguments.shards > 0 ? fmt::format("pairs, part {}", arguments.shard)
                              : fmt::format("station {}", arguments.station);
}

/// Returns how many units failed.
int Work(const WorkArguments& arguments, const ExecutionContext& context,
         const SurveyProject& project, const SurveyOptions& options, EventSink* events) {
  const ArtifactStore store(arguments.folders.WorkDirectory(),
                            [&](const std::string& what) { context.Warning(what); });
  if (arguments.coordinate) {
    Coordinate(arguments, context, project, options, store, events);
    return 0;
  }
  if (arguments.shards > 0) {
    const auto work = arguments.batch ? RegisterBatchShard : RegisterPairShard;
    return work(project, options, {arguments.shard, arguments.shards}, context, store);
  }
  const auto count = static_cast<int>(project.stations.size());
  if (arguments.station < 0 || arguments.station >= count) {
    throw InputError({"--station", std::to_string(arguments.station),
                      fmt::format("0 to {}, the stations of {}", count - 1, project.path), ""});
  }
  const StationSpec& spec = project.stations[static_cast<std::size_t>(arguments.station)];
  return LoadStations({spec}, options, context, store).front().usable() ? 0 : 1;
}

}  // namespace

int WorkCommand(const WorkArguments& arguments) {
  const std::stop_token stop = InstallStopSignals();
  TerminalEvents events(TerminalEvents::Verbosity::kNormal);
  SurveyOptions options;
  const SurveyProject project =
      ReadSurveyProject(arguments.folders.project, OptionSections(options));
  const ExecutionContext context(TaskCpus().value_or(project.resources.threads), kRunSeed, &events,
                                 stop);
  WakeThreads(context);
  const double memory_gb = arguments.memory_gb.value_or(project.resources.memory_gb);
  LimitMemory(memory_gb, context.threads());
  try {
    const int failed = Work(arguments, context, project, options, &events);
    if (failed > 0) context.Info(fmt::format("{} failed; the final run names the reasons", failed));
    return failed > 0 ? kPartial : kComplete;
  } catch (const std::bad_alloc&) {  // outside a station or a pair
    throw MemoryUsedUp(PartOf(arguments), memory_gb);
  } catch (const Interrupted&) {
    return StopSignal() == SIGTERM ? kTerminated : kInterrupted;
  }
}

}  // namespace backsight
