#include <fmt/format.h>

#include <map>

#include "io/artifact_store.h"
#include "io/folder_lock.h"
#include "io/run_json.h"
#include "pipeline/checked_project.h"
#include "pipeline/commands/commands.h"
#include "pipeline/latest_run.h"
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
    fmt::print("  {}: {}{}\n", item.unit, StateText(item),
               item.why.empty() ? "" : " (" + item.why + ")");
  }
}

void PrintGroup(const std::string& name, const std::vector<PlanItem>& items) {
  fmt::print("{}: {} of {} up to date\n", name, CountDone(items), items.size());
  PrintItems(items);
}

/// What Slurm knows of the jobs that were submitted.
struct JobStates {
  SlurmJobs jobs;                  ///< none where the run is of this machine
  std::vector<QueuedJob> queued;   ///< those that go on
  std::optional<std::string> why;  ///< it cannot be asked
};

JobStates AskForJobs(const std::string& work) {
  JobStates states;
  states.jobs = ReadSlurmJobs(work).value_or(SlurmJobs());
  if (states.jobs.jobs.empty()) return states;
  try {
    states.queued = QueuedJobs(states.jobs.Ids(), ExecutionContext());
  } catch (const SlurmUnreachable& failure) {
    states.why = failure.what();
  }
  return states;
}

/// Of jobs only the final one holds the lock for long.
void PrintRun(const std::string& work, const JobStates& states) {
  const std::optional<LockHolder> holder = HolderOf(work);
  if (!holder) {
    fmt::print("{}\n", !states.queued.empty() ? "jobs are going"
                       : states.why           ? "it is not known whether jobs are going"
                                              : "no run is going");
    return;
  }
  fmt::print("a run is going on {}, process {}, since {}", holder->host, holder->process,
             holder->since_utc);
  if (const auto progress = ReadProgress(work)) {
    fmt::print(": {} {} of {}", progress->stage, progress->done, progress->total);
  }
  fmt::print("\n");
}

bool HasResults(const RunPlan& plan) {
  return CountDone(plan.stations) + CountDone(plan.pairs) + CountDone(plan.network) +
             CountDone(plan.outputs) >
         0;
}

/// How the last run ended, and the one that wrote the reports: a run that is killed writes none.
void PrintLast(const OpenedProject& opened, const RunPlan& plan, const JobStates& states) {
  const bool goes_on = HolderOf(opened.work).has_value();  // asked first: a run ends in between
  const bool may_go_on = goes_on || !states.queued.empty() || states.why;
  const std::optional<LatestRun> run = ReadLatestRun(opened.work);
  if (run && run->ending) {
    fmt::print("last run: ended at {}: {} (exit code {})\n", run->ending->at_utc, run->ending->line,
               run->ending->exit_code);
  } else if (run && !may_go_on) {
    fmt::print(
        "last run: begun at {} on {}, process {}; it was killed, or the machine went down; run "
        "again to go on\n",
        run->since_utc, run->host, run->process);
  }
  const std::optional<LastRun> report = ReadLastRun(opened.out);
  if (report) fmt::print("last report: {} (exit code {})\n", report->verdict, report->exit_code);
  if (!run && !report && !may_go_on && states.jobs.jobs.empty() && !HasResults(plan)) {
    fmt::print(
        "no run has left a state in {} or a report in {}; one with --out or --work is found with "
        "the same options\n",
        opened.work, opened.out);
  }
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

void PrintJobs(const std::string& work, const JobStates& states) {
  if (states.jobs.jobs.empty()) return;
  fmt::print("Slurm jobs, submitted at {}:\n", states.jobs.submitted_utc);
  for (const SlurmJob& job : states.jobs.jobs) {
    fmt::print(
        "  {} {}, {} task(s): {}\n", job.id, job.part, job.tasks,
        states.why ? fmt::format("not known ({})", *states.why) : StatesOf(job, states.queued));
  }
  const std::optional<SlurmResult> result = ReadSlurmResult(work, states.jobs.Final());
  if (result) fmt::print("  result: {} (exit code {})\n", result->summary, result->exit_code);
}

}  // namespace

int PrintDryRun(const RunFolders& folders, const StageRange& stages) {
  const OpenedProject opened = Open(folders);
  RunPlan plan = PlanOf(opened);
  Restrict(stages, &plan);
  fmt::print("{}: {}\n", opened.project.name,
             !plan.done()                    ? "a run would do:"
             : stages.last < Stage::kNetwork ? "everything that was asked for is up to date"
                                             : "everything is up to date; only the reports would "
                                               "be written");
  for (const auto* items : {&plan.stations, &plan.pairs, &plan.network, &plan.outputs}) {
    PrintItems(*items);
  }
  return kComplete;
}

int StatusCommand(const RunFolders& folders) {
  const OpenedProject opened = Open(folders);
  const RunPlan plan = PlanOf(opened);
  fmt::print("{}: ", opened.project.name);
  const JobStates states = AskForJobs(opened.work);
  PrintRun(opened.work, states);
  PrintJobs(opened.work, states);
  PrintGroup("stations", plan.stations);
  PrintGroup(plan.all_pairs ? "pairs" : "pairs of the stored network", plan.pairs);
  PrintGroup("network", plan.network);
  PrintGroup("outputs", plan.outputs);
  PrintLast(opened, plan, states);
  return kComplete;
}

}  // namespace backsight
