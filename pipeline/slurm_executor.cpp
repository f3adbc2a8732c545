#include "pipeline/slurm_executor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "io/atomic_file.h"
#include "io/output_names.h"
#include "io/utc_text.h"
#include "pipeline/run_outputs.h"
#include "pipeline/sbatch_options.h"
#include "pipeline/slurm_client.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

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

}  // namespace backsight
