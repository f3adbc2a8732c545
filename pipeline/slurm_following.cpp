#include "pipeline/slurm_following.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipeline/progress_file.h"
#include "pipeline/slurm_client.h"

namespace backsight {
namespace {

using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

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

}  // namespace backsight
