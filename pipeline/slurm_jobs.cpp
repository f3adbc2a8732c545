#include "pipeline/slurm_jobs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "io/atomic_file.h"
#include "pipeline/slurm_client.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string PathIn(const std::string& work, const char* name) {
  return (fs::path(SlurmFolder(work)) / name).string();
}

/// What `read` makes of the file; nothing where that is missing or not as it should be.
template <class Result>
std::optional<Result> ReadJson(const std::string& path, Result (*read)(const json&)) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  try {
    return read(json::parse(file));
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

SlurmJobs JobsFrom(const json& root) {
  SlurmJobs jobs;
  jobs.submitted_utc = root.at("submitted_utc").get<std::string>();
  for (const json& job : root.at("jobs")) {
    jobs.jobs.push_back({job.at("id").get<std::string>(), job.at("part").get<std::string>(),
                         job.at("tasks").get<int>()});
  }
  return jobs;
}

SlurmResult ResultFrom(const json& root) {
  return {root.at("job").get<std::string>(), root.at("exit_code").get<int>(),
          root.at("summary").get<std::string>()};
}

std::string Text(const json& root) {
  return root.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void Remove(const std::string& work, const char* name) {
  std::error_code error;
  fs::remove(PathIn(work, name), error);
}

}  // namespace

std::vector<std::string> SlurmJobs::Ids() const {
  std::vector<std::string> ids;
  for (const SlurmJob& job : jobs) ids.push_back(job.id);
  return ids;
}

std::string SlurmJobs::IdsText() const { return fmt::format("{}", fmt::join(Ids(), " ")); }

std::string SlurmJobs::Final() const {
  for (const SlurmJob& job : jobs) {
    if (job.part == "final") return job.id;
  }
  return "";
}

std::optional<std::vector<SlurmJob>> SlurmJobs::After(const std::string& id) const {
  auto job = std::find_if(jobs.begin(), jobs.end(), [&](const auto& j) { return j.id == id; });
  if (job == jobs.end()) return std::nullopt;
  std::vector<SlurmJob> after;
  std::copy_if(std::next(job), jobs.end(), std::back_inserter(after),
               [](const SlurmJob& j) { return j.part != "final"; });
  return after;
}

std::string SlurmFolder(const std::string& work) { return (fs::path(work) / "slurm").string(); }

std::optional<SlurmJobs> ReadSlurmJobs(const std::string& work) {
  return ReadJson(PathIn(work, "jobs.json"), JobsFrom);
}

void WriteSlurmJobs(const std::string& work, const SlurmJobs& jobs) {
  json list = json::array();
  for (const SlurmJob& job : jobs.jobs) {
    list.push_back({{"id", job.id}, {"part", job.part}, {"tasks", job.tasks}});
  }
  WriteTextFile(
      PathIn(work, "jobs.json"),
      Text({{"schema_version", 1}, {"submitted_utc", jobs.submitted_utc}, {"jobs", list}}));
}

void ForgetSlurmJobs(const std::string& work) { Remove(work, "jobs.json"); }

std::optional<SlurmResult> ReadSlurmResult(const std::string& work, const std::string& job) {
  auto result = ReadJson(PathIn(work, "result.json"), ResultFrom);
  return result && result->job == job ? result : std::nullopt;
}

void WriteSlurmResult(const std::string& work, const SlurmResult& result) {
  WriteTextFile(PathIn(work, "result.json"), Text({{"schema_version", 1},
                                                   {"job", result.job},
                                                   {"exit_code", result.exit_code},
                                                   {"summary", result.summary}}));
}

void ForgetSlurmResult(const std::string& work) { Remove(work, "result.json"); }

void RequireNoJobs(const std::string& work, bool force, const ExecutionContext& context) {
  const std::optional<SlurmJobs> jobs = ReadSlurmJobs(work);
  if (!jobs || jobs->jobs.empty()) return;
  const std::string final = jobs->Final();
  if (!final.empty() && (final == OwnJob() || ReadSlurmResult(work, final))) return;
  try {
    if (QueuedJobs(jobs->Ids(), context).empty()) return;
  } catch (const SlurmUnreachable& failure) {
    if (force) return;
    throw FolderInUse(fmt::format(
        "{}: jobs {} were submitted at {}, and Slurm cannot be asked whether they have ended "
        "({}); run it where squeue works, or with --force if you know that they have",
        work, jobs->IdsText(), jobs->submitted_utc, failure.what()));
  }
  throw FolderInUse(fmt::format(
      "{} is in use: jobs {} are queued or running, submitted at {}; wait for their end, or cancel "
      "them: scancel {}",
      work, jobs->IdsText(), jobs->submitted_utc, jobs->IdsText()));
}

FolderLock LockWhenFree(const std::string& work, const ExecutionContext& context) {
  using Clock = std::chrono::steady_clock;
  const auto patient_until = Clock::now() + std::chrono::seconds(60);
  while (HolderOf(work) && Clock::now() < patient_until) {
    context.CheckStop();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  return FolderLock(work);
}

}  // namespace backsight
