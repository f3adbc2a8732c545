#include "pipeline/slurm_executor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "io/atomic_file.h"
#include "io/folder_lock.h"
#include "io/output_names.h"
#include "io/utc_text.h"
#include "pipeline/progress_file.h"
#include "pipeline/run_outputs.h"
#include "pipeline/sbatch_options.h"
#include "pipeline/slurm_client.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

// What Slurm hands to a script as arguments needs no quoting.
constexpr const char* kSingleScript = "#!/bin/sh\nexec \"$@\"\n";
constexpr const char* kArrayScript = "#!/bin/sh\nexec \"$@\" \"$SLURM_ARRAY_TASK_ID\"\n";

class Submitter {
 public:
  /// `earlier`: jobs of the same run.
  Submitter(const SlurmSubmission& submission, const ExecutionContext& context,
            SlurmJobs earlier = {})
      : submission_(submission),
        context_(context),
        earlier_(std::move(earlier)),
        jobs_(earlier_),
        work_(AbsolutePath(submission.work)),
        folder_(SlurmFolder(work_)),
        options_(SbatchOptions(submission.options)) {
    MakeDirectories((fs::path(folder_) / "logs").string());
    WriteTextFile(ScriptPath(0), kSingleScript);
    WriteTextFile(ScriptPath(1), kArrayScript);
    if (jobs_.jobs.empty()) jobs_.submitted_utc = UtcText(std::chrono::system_clock::now());
  }

  /// `tasks` and `after` as in SlurmRequest; an array's tasks get their number as last argument.
  /// Returns the job's id.
  std::string Submit(const std::string& part, int tasks, const std::string& after,
                     const std::vector<std::string>& arguments) {
    context_.CheckStop();
    SlurmRequest request;
    request.name = "backsight-" + part;
    request.tasks = tasks;
    request.after = after;
    request.script = ScriptPath(tasks);
    request.log = EscapePattern((fs::path(folder_) / "logs").string()) + "/" +
                  (tasks > 0 ? "%A_%a.out" : "%j.out");
    request.threads = submission_.threads;
    request.memory_gb = submission_.memory_gb;
    request.options = options_;
    request.command = {fs::read_symlink("/proc/self/exe").string()};
    request.command.insert(request.command.end(), arguments.begin(), arguments.end());
    jobs_.jobs.push_back({SubmitJob(request, context_), part, std::max(tasks, 1)});
    WriteSlurmJobs(work_, jobs_);
    return jobs_.jobs.back().id;
  }

  /// Cancels what was submitted here. Where Slurm does not do it, the jobs stay in jobs.json.
  void TakeBack() {
    const std::vector<std::string> all = jobs_.Ids();
    const std::vector<std::string> ids(
        all.begin() + static_cast<std::ptrdiff_t>(earlier_.jobs.size()), all.end());
    try {
      CancelJobs(ids);
    } catch (const SlurmUnreachable& failure) {
      return context_.Warning(fmt::format(
          "jobs {0} had been submitted and could not be cancelled ({1}); cancel them: scancel {0}",
          fmt::join(ids, " "), failure.what()));
    }
    if (earlier_.jobs.empty()) return ForgetSlurmJobs(work_);
    WriteSlurmJobs(work_, earlier_);
  }

  /// `command`, the project, its folders and what it may use.
  std::vector<std::string> Arguments(const std::string& command) const {
    return {command,       AbsolutePath(submission_.project),
            "--out",       AbsolutePath(submission_.out),
            "--work",      work_,
            "--memory-gb", fmt::format("{}", submission_.memory_gb)};
  }

  const SlurmJobs& jobs() const { return jobs_; }

 private:
  std::string ScriptPath(int tasks) const {
    return (fs::path(folder_) / (tasks > 0 ? "array.sh" : "single.sh")).string();
  }

  const SlurmSubmission& submission_;
  const ExecutionContext& context_;
  const SlurmJobs earlier_;
  SlurmJobs jobs_;
  const std::string work_;
  const std::string folder_;
  const std::vector<std::string> options_;
};

std::vector<std::string> With(std::vector<std::string> words, std::vector<std::string> more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string SubmitShards(Submitter* submitter, int shards, const std::string& after) {
  return submitter->Submit(
      "pairs", shards, after,
      With(submitter->Arguments("work"), {"--shards", std::to_string(shards), "--shard"}));
}

/// `done`: attempts that are stored when a round begins; none before the first.
std::string SubmitCoordinator(Submitter* submitter, const SlurmSubmission& submission,
                              const std::vector<std::string>& done, const std::string& after) {
  std::vector<std::string> words = {"--coordinate", "--threads",
                                    std::to_string(submission.threads)};
  if (!submission.options.empty()) words.push_back("--slurm-options=" + submission.options);
  return submitter->Submit("coordinator", 0, after,
                           With(With(submitter->Arguments("work"), words), done));
}

/// Puts the next coordinator behind an array, and has the final job wait: first for the array, so
/// that it never begins beside that, whatever happens to this process.
void CloseRound(Submitter* submitter, const SlurmSubmission& submission, const std::string& array,
                const std::vector<std::string>& done, const ExecutionContext& context) {
  const std::string final = submitter->jobs().Final();
  MakeJobWait(final, array, context);
  MakeJobWait(final, SubmitCoordinator(submitter, submission, done, array), context);
}

/// Cancels what `body` has submitted if it fails.
template <class Body>
void AllOrNothing(Submitter* submitter, Body body) {
  try {
    body();
  } catch (...) {
    submitter->TakeBack();
    throw;
  }
}

bool IsWaiting(const std::string& job, const ExecutionContext& context) {
  const std::vector<QueuedJob> queued = QueuedJobs({job}, context);
  return std::any_of(queued.begin(), queued.end(),
                     [](const auto& found) { return found.state == "PENDING"; });
}

/// Counts what is up to date.
void ShowItems(const char* stage, const std::vector<PlanItem>& items,
               const ExecutionContext& context) {
  context.Progress(stage, CountDone(items), items.size());
}

bool Has(const std::vector<QueuedJob>& queued, const std::string& id) {
  return std::any_of(queued.begin(), queued.end(), [&](const auto& job) { return job.id == id; });
}

bool IsRunning(const std::vector<QueuedJob>& queued, const std::string& id) {
  return std::any_of(queued.begin(), queued.end(),
                     [&](const auto& job) { return job.id == id && job.state == "RUNNING"; });
}

/// Shows how far the jobs are.
class JobProgress {
 public:
  JobProgress(const SlurmJobs& jobs, std::string work, const std::function<RunPlan()>& plan,
              const ExecutionContext& context)
      : jobs_(jobs), work_(std::move(work)), plan_(plan), context_(context) {}

  void Show(const std::vector<QueuedJob>& queued) {
    const bool final_runs = IsRunning(queued, jobs_.Final());
    if (!pairs_ended_) {
      const RunPlan plan = plan_();
      if (!stations_ended_) ShowItems("stations", plan.stations, context_);
      stations_ended_ = final_runs || !Has(queued, jobs_.jobs.front().id);
      if (stations_ended_) ShowItems("pairs", plan.pairs, context_);
      pairs_ended_ = final_runs;
    }
    const std::optional<RunProgress> progress = final_runs ? ReadProgress(work_) : std::nullopt;
    if (progress) context_.Progress(progress->stage, progress->done, progress->total);
  }

 private:
  const SlurmJobs& jobs_;
  const std::string work_;
  const std::function<RunPlan()>& plan_;
  const ExecutionContext& context_;
  bool stations_ended_ = false;
  bool pairs_ended_ = false;
};

/// Warns once where Slurm does not answer for minutes; it may answer again.
class Silence {
 public:
  explicit Silence(const ExecutionContext& context) : context_(context) {}

  void End() { answered_ = Clock::now(); }
  void GoesOn(const std::string& why) {
    constexpr auto kLongest = std::chrono::minutes(3);
    context_.Debug(why);
    if (warned_ || Clock::now() - answered_ < kLongest) return;
    warned_ = true;
    context_.Warning("for minutes Slurm has not said how far the jobs are: " + why);
  }

 private:
  const ExecutionContext& context_;
  Clock::time_point answered_ = Clock::now();
  bool warned_ = false;
};

/// Wakes up early if a stop is requested.
void Sleep(std::chrono::milliseconds time, const ExecutionContext& context) {
  const auto end = Clock::now() + time;
  while (Clock::now() < end) {
    context.CheckStop();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace

SlurmJobs SubmitSurvey(const SlurmSubmission& submission, int stations, int shards,
                       const ExecutionContext& context) {
  Submitter submitter(submission, context);
  AllOrNothing(&submitter, [&] {
    std::string last = submitter.Submit("stations", stations, "",
                                        With(submitter.Arguments("work"), {"--station"}));
    last = shards > 0 ? SubmitShards(&submitter, shards, last)
                      : SubmitCoordinator(&submitter, submission, {}, last);
    submitter.Submit("final", 0, last,
                     With(With(submitter.Arguments("run"), {"--executor", "local", "--final-job"}),
                          submission.final_words));
  });
  return submitter.jobs();
}

std::optional<SlurmJobs> JobsToContinue(const SlurmSubmission& submission, const std::string& own,
                                        const ExecutionContext& context) {
  const std::optional<SlurmJobs> jobs = ReadSlurmJobs(submission.work);
  const auto begun = jobs ? jobs->After(own) : std::nullopt;
  if (!begun || jobs->Final().empty() || !IsWaiting(jobs->Final(), context)) {
    context.Info("no final job waits for this coordinator");
    return std::nullopt;
  }
  if (begun->empty()) return jobs;
  const bool whole = std::any_of(begun->begin(), begun->end(),
                                 [](const SlurmJob& job) { return job.part == "coordinator"; });
  context.Info("the next pairs are with other jobs already");
  const std::string& last = begun->back().id;
  if (whole) {
    MakeJobWait(jobs->Final(), last, context);
    return std::nullopt;
  }
  Submitter submitter(submission, context, *jobs);
  AllOrNothing(&submitter, [&] { CloseRound(&submitter, submission, last, {}, context); });
  return std::nullopt;
}

void SubmitRound(const SlurmSubmission& submission, const SlurmJobs& jobs, int shards,
                 std::size_t done, const ExecutionContext& context) {
  Submitter submitter(submission, context, jobs);
  AllOrNothing(&submitter, [&] {
    const std::string array =
        submitter.Submit("pairs", shards, "",
                         With(submitter.Arguments("work"),
                              {"--batch", "--shards", std::to_string(shards), "--shard"}));
    CloseRound(&submitter, submission, array, {"--done", std::to_string(done)}, context);
  });
}

std::optional<SlurmResult> FollowJobs(const SlurmJobs& jobs, const std::string& work,
                                      const std::function<RunPlan()>& plan,
                                      const ExecutionContext& context) {
  constexpr auto kLongestPause = std::chrono::milliseconds(15'000);
  // A shared file system may show the result later than Slurm shows the end.
  constexpr auto kPatience = seconds(60);
  JobProgress progress(jobs, work, plan, context);
  std::chrono::milliseconds pause(1000);
  Silence silence(context);
  Clock::time_point patient_until = Clock::time_point::max();
  while (true) {
    context.CheckStop();
    if (auto result = ReadSlurmResult(work, jobs.Final())) return result;
    if (Clock::now() > patient_until) return std::nullopt;
    try {
      const std::vector<QueuedJob> queued =
          QueuedJobs(ReadSlurmJobs(work).value_or(jobs).Ids(), context);
      silence.End();
      if (queued.empty()) {
        patient_until = std::min(patient_until, Clock::now() + kPatience);
      } else {
        patient_until = Clock::time_point::max();
        progress.Show(queued);
      }
    } catch (const SlurmUnreachable& failure) {
      silence.GoesOn(failure.what());
    }
    Sleep(pause, context);
    pause = std::min(pause + pause / 4, kLongestPause);
  }
}

FolderLock LockWhenFree(const std::string& work, const ExecutionContext& context) {
  const auto patient_until = Clock::now() + seconds(60);
  while (HolderOf(work) && Clock::now() < patient_until) {
    Sleep(std::chrono::milliseconds(200), context);
  }
  return FolderLock(work);
}

}  // namespace backsight
