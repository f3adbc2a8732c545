#include "pipeline/slurm_executor.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "io/atomic_file.h"
#include "io/folder_lock.h"
#include "pipeline/option_words.h"
#include "pipeline/progress_file.h"
#include "pipeline/run_outputs.h"
#include "pipeline/slurm_client.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

// What Slurm hands to a script as arguments needs no quoting.
constexpr const char* kSingleScript = "#!/bin/sh\nexec \"$@\"\n";
constexpr const char* kArrayScript = "#!/bin/sh\nexec \"$@\" \"$SLURM_ARRAY_TASK_ID\"\n";

std::string Absolute(const std::string& path) {
  return fs::absolute(path).lexically_normal().string();
}

std::string NowUtc() {
  const auto now = std::chrono::time_point_cast<seconds>(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", now);
}

class Submitter {
 public:
  explicit Submitter(const SlurmSubmission& submission)
      : submission_(submission),
        work_(Absolute(submission.work)),
        folder_(SlurmFolder(work_)),
        options_(SplitWords(submission.options, "--slurm-options")) {
    MakeDirectories((fs::path(folder_) / "logs").string());
    WriteTextFile(ScriptPath(0), kSingleScript);
    WriteTextFile(ScriptPath(1), kArrayScript);
    jobs_.submitted_utc = NowUtc();
  }

  /// `tasks` as in SlurmRequest. The command's last argument is the number of the task.
  void Submit(const std::string& part, int tasks, const std::vector<std::string>& arguments) {
    SlurmRequest request;
    request.name = "backsight-" + part;
    request.tasks = tasks;
    request.after = jobs_.jobs.empty() ? "" : jobs_.jobs.back().id;
    request.script = ScriptPath(tasks);
    request.log = EscapePattern((fs::path(folder_) / "logs").string()) + "/" +
                  (tasks > 0 ? "%A_%a.out" : "%j.out");
    request.threads = submission_.threads;
    request.memory_gb = submission_.memory_gb;
    request.options = options_;
    request.command = {fs::read_symlink("/proc/self/exe").string()};
    request.command.insert(request.command.end(), arguments.begin(), arguments.end());
    try {
      jobs_.jobs.push_back({SubmitJob(request), part, std::max(tasks, 1)});
      WriteSlurmJobs(work_, jobs_);
    } catch (...) {
      CancelJobs(jobs_.Ids());
      ForgetSlurmJobs(work_);
      throw;
    }
  }

  /// `command`, the project, its folders and what it may use.
  std::vector<std::string> Arguments(const std::string& command) const {
    return {command,       Absolute(submission_.project),
            "--out",       Absolute(submission_.out),
            "--work",      work_,
            "--memory-gb", fmt::format("{}", submission_.memory_gb)};
  }

  const SlurmJobs& jobs() const { return jobs_; }

 private:
  std::string ScriptPath(int tasks) const {
    return (fs::path(folder_) / (tasks > 0 ? "array.sh" : "single.sh")).string();
  }

  const SlurmSubmission& submission_;
  const std::string work_;
  const std::string folder_;
  const std::vector<std::string> options_;
  SlurmJobs jobs_;
};

std::vector<std::string> With(std::vector<std::string> words, std::vector<std::string> more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Counts what is up to date.
void ShowItems(const char* stage, const std::vector<PlanItem>& items,
               const ExecutionContext& context) {
  const auto done =
      std::count_if(items.begin(), items.end(), [](const auto& i) { return i.done(); });
  context.Progress(stage, static_cast<std::size_t>(done), items.size());
}

bool Has(const std::vector<QueuedJob>& queued, const std::string& id) {
  return std::any_of(queued.begin(), queued.end(), [&](const auto& job) { return job.id == id; });
}

bool IsRunning(const std::vector<QueuedJob>& queued, const std::string& id) {
  return std::any_of(queued.begin(), queued.end(),
                     [&](const auto& job) { return job.id == id && job.state == "RUNNING"; });
}

void ShowProgress(const SlurmJobs& jobs, const std::vector<QueuedJob>& queued,
                  const std::string& work, const std::function<RunPlan()>& plan,
                  const ExecutionContext& context) {
  if (IsRunning(queued, jobs.Final())) {
    const std::optional<RunProgress> progress = ReadProgress(work);
    if (progress) context.Progress(progress->stage, progress->done, progress->total);
    return;
  }
  const RunPlan now = plan();
  if (Has(queued, jobs.jobs.front().id)) return ShowItems("stations", now.stations, context);
  ShowItems("pairs", now.pairs, context);
}

/// Wakes up early if a stop is requested.
void Sleep(std::chrono::milliseconds time, const ExecutionContext& context) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
    context.CheckStop();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace

SlurmJobs SubmitSurvey(const SlurmSubmission& submission, int stations, int shards) {
  Submitter submitter(submission);
  submitter.Submit("stations", stations, With(submitter.Arguments("work"), {"--station"}));
  if (shards > 0) {
    submitter.Submit(
        "pairs", shards,
        With(submitter.Arguments("work"), {"--shards", std::to_string(shards), "--shard"}));
  }
  submitter.Submit("final", 0,
                   With(With(submitter.Arguments("run"), {"--executor", "local", "--final-job"}),
                        submission.final_words));
  return submitter.jobs();
}

std::optional<SlurmResult> FollowJobs(const SlurmJobs& jobs, const std::string& work,
                                      const std::function<RunPlan()>& plan,
                                      const ExecutionContext& context) {
  constexpr auto kLongestPause = std::chrono::milliseconds(15'000);
  // A shared file system may show the result later than Slurm shows the end.
  constexpr auto kPatience = seconds(60);
  std::chrono::milliseconds pause(1000);
  using Clock = std::chrono::steady_clock;
  Clock::time_point patient_until = Clock::time_point::max();
  while (true) {
    context.CheckStop();
    if (auto result = ReadSlurmResult(work, jobs.Final())) return result;
    if (Clock::now() > patient_until) return std::nullopt;
    try {
      const std::vector<QueuedJob> queued = QueuedJobs(jobs.Ids());
      if (queued.empty()) {
        patient_until = std::min(patient_until, Clock::now() + kPatience);
      } else {
        patient_until = Clock::time_point::max();
        ShowProgress(jobs, queued, work, plan, context);
      }
    } catch (const SlurmUnreachable& failure) {
      context.Debug(failure.what());  // it may answer again
    }
    Sleep(pause, context);
    pause = std::min(pause + pause / 4, kLongestPause);
  }
}

void AwaitSubmission(const std::string& work) {
  const auto start = std::chrono::steady_clock::now();
  while (HolderOf(work) && std::chrono::steady_clock::now() - start < seconds(60)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

}  // namespace backsight
