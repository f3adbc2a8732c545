#include <fmt/format.h>

#include <map>

#include "io/artifact_store.h"
#include "io/folder_lock.h"
#include "io/run_json.h"
#include "pipeline/checked_project.h"
#include "pipeline/commands/commands.h"
#include "pipeline/output_files.h"
#include "pipeline/progress_file.h"
#include "pipeline/run_plan.h"
#include "pipeline/slurm_client.h"
#include "pipeline/slurm_jobs.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

struct OpenedProject {
  SurveyOptions options;
  SurveyProject project;
  std::string out;
  std::string work;
};

OpenedProject Open(const RunFolders& folders) {
  OpenedProject opened;
  opened.project = ReadCheckedProject(folders.project, &opened.options);
  opened.out = folders.OutDirectory();
  opened.work = folders.WorkDirectory();
  return opened;
}

RunPlan PlanOf(const OpenedProject& opened) {
  return MakeRunPlan(opened.project, opened.options, kRunSeed, opened.out,
                     ArtifactStore(opened.work));
}

void PrintItems(const std::vector<PlanItem>& items) {
  for (const PlanItem& item : items) {
    if (item.done()) continue;
    fmt::print("  {}: {}{}\n", item.unit, ToString(item.state),
               item.why.empty() ? "" : " (" + item.why + ")");
  }
}

void PrintGroup(const std::string& name, const std::vector<PlanItem>& items) {
  fmt::print("{}: {} of {} up to date\n", name, CountDone(items), items.size());
  PrintItems(items);
}

void PrintRun(const std::string& work) {
  const std::optional<LockHolder> holder = HolderOf(work);
  if (!holder) {
    fmt::print("no run is going\n");
    return;
  }
  fmt::print("a run is going on {}, process {}, since {}", holder->host, holder->process,
             holder->since_utc);
  if (const auto progress = ReadProgress(work)) {
    fmt::print(": {} {} of {}", progress->stage, progress->done, progress->total);
  }
  fmt::print("\n");
}

/// "2 RUNNING, 4 PENDING"
std::string StatesOf(const SlurmJob& job, const std::vector<QueuedJob>& queued) {
  std::map<std::string, int> states;
  for (const QueuedJob& task : queued) {
    if (task.id == job.id) ++states[task.state];
  }
  std::string text;
  for (const auto& [state, count] : states) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
  }
  return text.empty() ? "ended" : text;
}

void PrintJobs(const std::string& work) {
  const std::optional<SlurmJobs> jobs = ReadSlurmJobs(work);
  if (!jobs || jobs->jobs.empty()) return;
  fmt::print("Slurm jobs, submitted at {}:\n", jobs->submitted_utc);
  std::vector<QueuedJob> queued;
  std::string unknown;
  try {
    queued = QueuedJobs(jobs->Ids(), ExecutionContext());
  } catch (const SlurmUnreachable& failure) {
    unknown = fmt::format("not known ({})", failure.what());
  }
  for (const SlurmJob& job : jobs->jobs) {
    fmt::print("  {} {}, {} task(s): {}\n", job.id, job.part, job.tasks,
               unknown.empty() ? StatesOf(job, queued) : unknown);
  }
  const std::optional<SlurmResult> result = ReadSlurmResult(work, jobs->Final());
  if (result) fmt::print("  result: {} (exit code {})\n", result->summary, result->exit_code);
}

}  // namespace

int PrintDryRun(const RunFolders& folders) {
  const OpenedProject opened = Open(folders);
  const RunPlan plan = PlanOf(opened);
  fmt::print("{}: {}\n", opened.project.name,
             plan.done() ? "everything is up to date; only the reports would be written"
                         : "a run would do:");
  for (const auto* items : {&plan.stations, &plan.pairs, &plan.network, &plan.outputs}) {
    PrintItems(*items);
  }
  return kComplete;
}

int StatusCommand(const RunFolders& folders) {
  const OpenedProject opened = Open(folders);
  const RunPlan plan = PlanOf(opened);
  fmt::print("{}: ", opened.project.name);
  PrintRun(opened.work);
  PrintJobs(opened.work);
  PrintGroup("stations", plan.stations);
  PrintGroup("pairs", plan.pairs);
  PrintGroup("network", plan.network);
  PrintGroup("outputs", plan.outputs);
  const std::optional<LastRun> last = ReadLastRun(opened.out);
  if (last) fmt::print("last report: {} (exit code {})\n", last->verdict, last->exit_code);
  return kComplete;
}

}  // namespace backsight
