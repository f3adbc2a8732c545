#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <optional>

#include "core/error.h"
#include "core/fingerprint.h"
#include "io/artifact_store.h"
#include "io/atomic_file.h"
#include "io/folder_lock.h"
#include "io/run_json.h"
#include "io/utc_text.h"
#include "pipeline/checked_project.h"
#include "pipeline/commands/commands.h"
#include "pipeline/commands/run_on_slurm.h"
#include "pipeline/control_frame.h"
#include "pipeline/latest_run.h"
#include "pipeline/output_files.h"
#include "pipeline/progress_file.h"
#include "pipeline/resource_budget.h"
#include "pipeline/run_events.h"
#include "pipeline/run_outputs.h"
#include "pipeline/run_plan.h"
#include "pipeline/slurm_client.h"
#include "pipeline/slurm_jobs.h"
#include "pipeline/stop_signal.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::system_clock;

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux counts in kB
}

std::string EffectiveOptions(SurveyOptions options) {
  std::string text;
  for (const OptionSection& section : OptionSections(options)) text += CanonicalText(section);
  return text;
}

/// Times, memory and inputs: what may differ between equal runs.
void WriteManifest(const SurveyProject& project, const SurveyOptions& options, const SurveyRun& run,
                   Clock::time_point start, int threads, const std::string& out) {
  ManifestRecord manifest;
  manifest.version = kVersion;
  manifest.git_hash = kGitHash;
  manifest.project_path = project.path;
  manifest.options = EffectiveOptions(options);
  for (std::size_t s = 0; s < project.stations.size(); ++s) {
    manifest.inputs.emplace_back(project.stations[s].scan, run.scan_fingerprints[s]);
  }
  manifest.started_utc = UtcText(start);
  manifest.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  manifest.peak_memory_mb = PeakMemoryMb();
  manifest.threads = threads;
  manifest.stages = run.times;
  for (const OutputRecord& file : run.record.outputs) {
    const std::optional<WrittenCloud> cloud = file.points ? DescribeFile(file.path) : std::nullopt;
    if (cloud) manifest.clouds.push_back(*cloud);
  }
  WriteTextFile((fs::path(out) / "manifest.json").string(), ManifestJson(manifest));
}

TerminalEvents::Verbosity VerbosityOf(const RunArguments& arguments) {
  if (arguments.quiet) return TerminalEvents::Verbosity::kQuiet;
  return arguments.verbose ? TerminalEvents::Verbosity::kVerbose
                           : TerminalEvents::Verbosity::kNormal;
}

RunStart DescribeStart(const SurveyProject& project, const SurveyOptions& options, int threads,
                       const std::string& out) {
  return {.project = project.path,
          .name = project.name,
          .out = out,
          .stations = static_cast<int>(project.stations.size()),
          .threads = threads,
          .options_fingerprint = FingerprintText(EffectiveOptions(options))};
}

int ThreadsOf(const RunArguments& arguments, const SurveyProject& project) {
  if (arguments.final_job) {
    if (const std::optional<int> given = TaskCpus()) return *given;
  }
  return arguments.threads >= 0 ? arguments.threads : project.resources.threads;
}

/// Where memory runs out outside a station or a pair, says when, and what to do.
SurveyRun RunWithin(double memory_gb, const ProgressFile& progress,
                    const std::function<SurveyRun()>& run) {
  try {
    return run();
  } catch (const std::bad_alloc&) {
    throw MemoryUsedUp(progress.place(), memory_gb);
  }
}

/// What takes room: outputs that are not asked for count as written.
RunPlan PlanRoom(const SurveyProject& project, const SurveyOptions& options, const std::string& out,
                 const std::string& work, Stage last) {
  RunPlan plan =
      MakeRunPlan(project, options, kRunSeed, out, ArtifactStore(work), EarlierFaults::kMend);
  if (last == Stage::kOutputs) return plan;
  for (PlanItem& output : plan.outputs) output.state = ArtifactState::Kind::kUpToDate;
  return plan;
}

/// What a run holds until it has said how it ended.
struct HeldFolder {
  std::unique_ptr<FolderLock> work;
  bool noted = false;  ///< that the run began
};

int RunProject(const RunArguments& arguments, const std::stop_token& stop, RunEvents* events,
               HeldFolder* held) {
  const Clock::time_point start = Clock::now();
  SurveyOptions options;
  const SurveyProject project = ReadCheckedProject(arguments.folders.project, &options);
  const auto frame = MakeControlFrame(project);

  const std::string out = arguments.folders.OutDirectory();
  const std::string work = arguments.folders.WorkDirectory();
  RequireFreeNames(project, out);
  // No such context may live when the run takes its threads.
  const auto waiting = [&] { return ExecutionContext(1, kRunSeed, events->sink(), stop); };
  held->work.reset(
      new FolderLock(arguments.final_job ? LockWhenFree(work, waiting()) : FolderLock(work)));
  ProgressFile progress(work);
  RequireNoJobs(work, arguments.force, waiting());
  NoteBeginning(work);
  held->noted = true;
  // What earlier jobs left must be told apart from what this run leaves.
  if (arguments.final_job) {
    ForgetSlurmResult(work);
  } else {
    ForgetSlurmJobs(work);
  }
  std::optional<FolderLock> out_lock;  // another work folder may lead to the same results
  if (!fs::exists(out) || !fs::equivalent(out, work)) out_lock.emplace(out);
  // Tasks of a submission may still be writing; its start has cleared the work folder.
  if (!arguments.final_job) RemoveHalfWrittenArtifacts(work);
  if (arguments.stages.from) ForgetFrom(*arguments.stages.from, work);
  RemoveTemporaries(project, out);

  WarningMemory said;
  EventFanOut sinks({events->sink(), &progress, &said});
  const ExecutionContext context(ThreadsOf(arguments, project), kRunSeed, &sinks, stop);
  events->Started(DescribeStart(project, options, context.threads(), out));
  const ArtifactStore store(work, [&](const std::string& what) { context.Warning(what); });
  const double memory_gb = arguments.memory_gb.value_or(project.resources.memory_gb);
  const RunPlan plan = PlanRoom(project, options, out, work, arguments.stages.last);
  RequireRoom(EstimateNeeds(project, out, store, &plan, context), memory_gb, context);
  WakeThreads(context);
  if (!LimitMemory(memory_gb, context.threads())) {
    context.Warning("the system does not limit this process's memory; it takes what it needs");
  }
  const SurveyRun run = RunWithin(memory_gb, progress, [&] {
    return RunSurvey(project, options, frame, out, context, store, arguments.stages.last);
  });
  // Terminals, logs and mails are to say all that the report warns of.
  for (const std::string& warning : run.record.warnings) {
    if (!said.Holds(warning)) context.Warning(warning);
  }
  if (arguments.stages.last < Stage::kNetwork) {
    return events->End(run.record.exit_code, run.record.verdict, "");
  }
  // It knows the clouds that lie there: where none was asked for, that of the last run stays.
  if (arguments.stages.last == Stage::kOutputs) {
    WriteManifest(project, options, run, start, context.threads(), out);
  }
  return events->Finished(run.record.exit_code, run.record.verdict,
                          (fs::path(out) / "report.html").string());
}

/// For `status` and whoever follows the jobs. An interrupted final job has no result: Slurm may
/// start it again.
void KeepResult(const RunArguments& arguments, const HeldFolder& held, const RunEvents& events) {
  const std::string work = arguments.folders.WorkDirectory();
  if (held.noted) NoteEnding(work, events.exit_code(), events.last_line());
  const int code = events.exit_code();
  if (!arguments.final_job || code == kInterrupted || code == kTerminated) return;
  WriteSlurmResult(work, {OwnJob(), code, events.last_line()});
}

}  // namespace

std::string RunFolders::OutDirectory() const {
  return out.empty() ? UsualOutDirectory(project) : out;
}

std::string RunFolders::WorkDirectory() const {
  return work.empty() ? UsualWorkDirectory(project) : work;
}

int RunCommand(const RunArguments& arguments) {
  if (arguments.dry_run) return PrintDryRun(arguments.folders, arguments.stages);
  const std::stop_token stop = InstallStopSignals();
  const bool on_slurm = arguments.executor == Executor::kSlurm;
  // The event log is the run's, which is the final job.
  RunEvents events(VerbosityOf(arguments), on_slurm ? "" : arguments.log_json);
  HeldFolder held;
  try {
    if (on_slurm) return RunOnSlurm(arguments, stop, &events);
    const int code = RunProject(arguments, stop, &events, &held);
    KeepResult(arguments, held, events);
    return code;
  } catch (const Interrupted&) {
    const int code = events.Interrupted(StopSignal());
    KeepResult(arguments, held, events);
    return code;
  } catch (const std::exception& error) {
    events.Failed(error);
    KeepResult(arguments, held, events);
    throw;
  }
}

}  // namespace backsight
