#include "pipeline/commands/run_on_slurm.h"

#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <limits>

#include "core/error.h"
#include "io/artifact_store.h"
#include "io/folder_lock.h"
#include "pipeline/checked_project.h"
#include "pipeline/output_files.h"
#include "pipeline/pair_shards.h"
#include "pipeline/resource_budget.h"
#include "pipeline/run_outputs.h"
#include "pipeline/run_plan.h"
#include "pipeline/slurm_executor.h"
#include "pipeline/slurm_following.h"
#include "pipeline/stop_signal.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

SlurmSubmission Describe(const RunArguments& arguments, const SurveyProject& project) {
  SlurmSubmission submission;
  submission.project = arguments.folders.project;
  submission.out = arguments.folders.OutDirectory();
  submission.work = arguments.folders.WorkDirectory();
  submission.threads = arguments.threads >= 0 ? arguments.threads : project.resources.threads;
  submission.memory_gb = arguments.memory_gb.value_or(project.resources.memory_gb);
  submission.options = arguments.slurm_options;
  if (arguments.verbose) submission.final_words.emplace_back("--verbose");
  if (arguments.quiet) submission.final_words.emplace_back("--quiet");
  if (!arguments.log_json.empty()) {
    const std::string log = fs::absolute(arguments.log_json).string();
    submission.final_words.insert(submission.final_words.end(), {"--log-json", log});
  }
  return submission;
}

/// As before a local run, but for the memory of this machine, on which nothing will run.
void RequireRoomOnDisks(const SurveyProject& project, const SurveyOptions& options,
                        const SlurmSubmission& submission, const ExecutionContext& context) {
  const ArtifactStore store(submission.work);
  const RunPlan plan =
      MakeRunPlan(project, options, kRunSeed, submission.out, store, EarlierFaults::kMend);
  ResourceNeeds needs = EstimateNeeds(project, submission.out, store, &plan, context);
  needs.physical_memory = std::numeric_limits<std::uint64_t>::max();
  RequireRoom(needs, submission.memory_gb, context);
}

SlurmJobs Submit(const RunArguments& arguments, const SurveyProject& project,
                 const SurveyOptions& options, const ExecutionContext& context) {
  const SlurmSubmission submission = Describe(arguments, project);
  RequireFreeNames(project, submission.out);
  const FolderLock lock(submission.work);
  RequireNoJobs(submission.work, arguments.force, context);
  MakeDirectories(submission.out);
  RemoveHalfWrittenArtifacts(submission.work);
  if (arguments.stages.from) ForgetFrom(*arguments.stages.from, submission.work);
  RemoveTemporaries(project, submission.out);
  RequireRoomOnDisks(project, options, submission, context);
  return SubmitSurvey(submission, static_cast<int>(project.stations.size()),
                      CountPairShards(project, options), context);
}

int Follow(const SlurmJobs& jobs, const std::string& work, const std::function<RunPlan()>& plan,
           const ExecutionContext& context, RunEvents* events) {
  try {
    const std::optional<SlurmResult> result = FollowJobs(jobs, work, plan, context);
    if (result) return events->End(result->exit_code, result->summary, "");
  } catch (const Interrupted&) {
    const std::string ids = ReadSlurmJobs(work).value_or(jobs).IdsText();  // rounds have added some
    return events->End(StopSignal() == SIGTERM ? kTerminated : kInterrupted,
                       fmt::format("Interrupted: the jobs {} go on without being followed.", ids),
                       fmt::format(" To cancel them: scancel {}", ids));
  }
  return events->End(
      kTryAgain, fmt::format("Failed: the final job {} ended without a result.", jobs.Final()),
      fmt::format(" Its log is in {}; the same command goes on from what is finished.",
                  (fs::path(SlurmFolder(work)) / "logs").string()));
}

}  // namespace

int RunOnSlurm(const RunArguments& arguments, const std::stop_token& stop, RunEvents* events) {
  SurveyOptions options;
  const SurveyProject project = ReadCheckedProject(arguments.folders.project, &options);
  const ExecutionContext context(1, kRunSeed, events->sink(), stop);
  const SlurmJobs jobs = Submit(arguments, project, options, context);
  if (!arguments.wait) {
    fmt::print("{}\n", jobs.IdsText());
    return kComplete;
  }
  events->Started({});
  context.Info("submitted jobs " + jobs.IdsText());
  const std::string work = arguments.folders.WorkDirectory();
  const auto plan = [&] {
    return MakeRunPlan(project, options, kRunSeed, arguments.folders.OutDirectory(),
                       ArtifactStore(work));
  };
  return Follow(jobs, work, plan, context, events);
}

}  // namespace backsight
