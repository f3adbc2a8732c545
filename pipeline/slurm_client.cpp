#include "pipeline/slurm_client.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>

#include "core/error.h"
#include "pipeline/child_process.h"

namespace backsight {
namespace {

/// Runs one of Slurm's commands; they answer within seconds.
ProgramEnd Ask(const std::vector<std::string>& words, const ExecutionContext& context) {
  constexpr double kPatienceS = 60.0;
  try {
    return RunProgram(words, context.WithTimeLimit(kPatienceS));
  } catch (const OverTimeLimit&) {
    throw SlurmUnreachable(fmt::format("{}: no answer within {:g} s", words.front(), kPatienceS));
  }
}

/// On one line, for a message.
std::string Said(const ProgramEnd& end) {
  if (!end.fault.empty()) return end.fault;
  std::string text = end.err + end.out;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ';');
  return text.empty() ? fmt::format("exit code {}", end.exit_code) : text;
}

bool Says(const ProgramEnd& end, std::string_view words) {
  return end.err.find(words) != std::string::npos;
}

bool IsUnreachable(const ProgramEnd& end) {
  return Says(end, "Unable to contact slurm controller") || Says(end, "Socket timed out") ||
         Says(end, "temporarily unable") || Says(end, "Unable to connect");
}

bool HasEnded(const std::string& state) {
  static const std::set<std::string> ended = {
      "BOOT_FAIL", "CANCELLED",     "COMPLETED", "DEADLINE", "FAILED",
      "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED",  "TIMEOUT"};
  return ended.contains(state);
}

std::vector<std::string> SbatchWords(const SlurmRequest& request) {
  std::vector<std::string> words = {"sbatch", "--parsable", "--requeue",
                                    "--job-name=" + request.name, "--output=" + request.log};
  if (request.tasks > 0) words.push_back(fmt::format("--array=0-{}", request.tasks - 1));
  if (!request.after.empty()) words.push_back("--dependency=afterany:" + request.after);
  if (request.threads > 0) words.push_back(fmt::format("--cpus-per-task={}", request.threads));
  // As docs/nightly.md has it: the budget is of data alone.
  const double mebibytes = std::ceil(1.25 * request.memory_gb * 1e9 / 1048576.0);
  words.push_back(fmt::format("--mem={:.0f}M", mebibytes));
  words.insert(words.end(), request.options.begin(), request.options.end());
  words.push_back(request.script);
  words.insert(words.end(), request.command.begin(), request.command.end());
  return words;
}

std::optional<int> NumberFrom(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return std::nullopt;
  const long number = std::strtol(text, nullptr, 10);
  return number > 0 && number <= 1024 ? std::optional(static_cast<int>(number)) : std::nullopt;
}

}  // namespace

std::string SubmitJob(const SlurmRequest& request, const ExecutionContext& context) {
  const ProgramEnd end = Ask(SbatchWords(request), context);
  if (end.exit_code != 0 && IsUnreachable(end)) throw SlurmUnreachable("sbatch: " + Said(end));
  const std::string id = end.out.substr(0, end.out.find_first_of(";\n"));  // "ID;CLUSTER"
  const bool is_id =
      !id.empty() && std::all_of(id.begin(), id.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (end.exit_code == 0 && is_id) return id;
  throw InputError({"sbatch", Said(end), "a Slurm that takes the job " + request.name,
                    end.fault.empty()
                        ? "see that --slurm-options, --threads and --memory-gb suit the cluster"
                        : "run it where Slurm's commands are installed, or --executor local"});
}

void CancelJobs(const std::vector<std::string>& ids) {
  if (ids.empty()) return;
  std::vector<std::string> words = {"scancel"};
  words.insert(words.end(), ids.begin(), ids.end());
  const ExecutionContext whatever_is_requested;
  const ProgramEnd end = Ask(words, whatever_is_requested);
  if (end.exit_code == 0 || QueuedJobs(ids, whatever_is_requested).empty()) return;
  throw SlurmUnreachable("scancel: " + Said(end));
}

void MakeJobWait(const std::string& job, const std::string& after,
                 const ExecutionContext& context) {
  const ProgramEnd end =
      Ask({"scontrol", "update", "JobId=" + job, "Dependency=afterany:" + after}, context);
  if (end.exit_code != 0) throw SlurmUnreachable("scontrol: " + Said(end));
}

std::vector<QueuedJob> QueuedJobs(const std::vector<std::string>& ids,
                                  const ExecutionContext& context) {
  const ProgramEnd end = Ask({"squeue", "--noheader", "--array", "--format=%F %T",
                              fmt::format("--jobs={}", fmt::join(ids, ","))},
                             context);
  if (end.exit_code != 0 && Says(end, "Invalid job id")) return {};  // forgotten: ended long ago
  if (end.exit_code != 0) throw SlurmUnreachable("squeue: " + Said(end));
  std::vector<QueuedJob> jobs;
  std::istringstream lines(end.out);
  QueuedJob job;
  while (lines >> job.id >> job.state) {
    if (!HasEnded(job.state)) jobs.push_back(job);
  }
  return jobs;
}

std::optional<int> TaskCpus() {
  if (OwnJob().empty()) return std::nullopt;
  const std::optional<int> wanted = NumberFrom("SLURM_CPUS_PER_TASK");
  return wanted ? wanted : NumberFrom("SLURM_CPUS_ON_NODE");
}

std::string OwnJob() {
  const char* id = std::getenv("SLURM_JOB_ID");
  return id == nullptr ? "" : id;
}

std::string EscapePattern(const std::string& path) {
  std::string escaped;
  for (const char c : path) escaped += c == '%' ? std::string("%%") : std::string(1, c);
  return escaped;
}

}  // namespace backsight
