#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>

#include "core/error.h"
#include "io/artifact_store.h"
#include "io/atomic_file.h"
#include "io/folder_lock.h"
#include "io/run_json.h"
#include "pipeline/commands/commands.h"
#include "pipeline/georeference_network.h"
#include "pipeline/output_files.h"
#include "pipeline/run_outputs.h"
#include "pipeline/stop_signal.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/terminal_events.h"
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
  manifest.started_utc = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                                     std::chrono::time_point_cast<std::chrono::seconds>(start));
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

int RefuseSecondRun(const LockHolder& holder, const std::string& work) {
  fmt::print(
      stderr,
      "error: {} is in use: a run is going on {}, process {}, since {}; wait for its end, or "
      "give another --work and --out\n",
      work, holder.host, holder.process, holder.since_utc);
  return kTryAgain;
}

}  // namespace

std::string RunFolders::OutDirectory() const {
  return out.empty() ? UsualOutDirectory(project) : out;
}

std::string RunFolders::WorkDirectory() const {
  return work.empty() ? UsualWorkDirectory(project) : work;
}

int RunCommand(const RunArguments& arguments) {
  if (arguments.dry_run) return PrintDryRun(arguments.folders);
  const Clock::time_point start = Clock::now();
  const std::stop_token stop = InstallStopSignals();
  SurveyOptions options;
  const SurveyProject project =
      ReadSurveyProject(arguments.folders.project, OptionSections(options));
  const auto frame = MakeControlFrame(project);  // refuses what no network could mend

  const std::string out = arguments.folders.OutDirectory();
  const std::string work = arguments.folders.WorkDirectory();
  RequireFreeNames(project, out);
  const FolderLock lock(work);
  if (!lock.held()) return RefuseSecondRun(*lock.holder(), work);
  MakeDirectories(out);
  RemoveTemporaries(project, out, work);
  TerminalEvents events(VerbosityOf(arguments));
  const int threads = arguments.threads >= 0 ? arguments.threads : project.resources.threads;
  const ExecutionContext context(threads, kRunSeed, &events, stop);
  try {
    const ArtifactStore store(work, [&](const std::string& what) { context.Warning(what); });
    const SurveyRun run = RunSurvey(project, options, frame, out, context, store);
    WriteManifest(project, options, run, start, context.threads(), out);
    fmt::print("{} Report: {}\n", run.record.verdict, (fs::path(out) / "report.html").string());
    return run.record.exit_code;
  } catch (const Interrupted&) {
    fmt::print(stderr,
               "interrupted; what is finished is kept, the same command goes on from there\n");
    return StopSignal() == SIGTERM ? kTerminated : kInterrupted;
  }
}

}  // namespace backsight
