#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/folder_lock.h"

namespace backsight {

/// What a job on the cluster is for.
struct SlurmJob {
  std::string id;
  std::string part;  ///< "stations", "pairs", "coordinator", "final"
  int tasks = 1;
};

/// The jobs of one submission.
struct SlurmJobs {
  std::string submitted_utc;  ///< ISO 8601
  std::vector<SlurmJob> jobs;

  std::vector<std::string> Ids() const;
  std::string IdsText() const;  ///< with blanks between
  /// The final job's id; empty while none is submitted.
  std::string Final() const;
  /// Those submitted after `id`, but for the final job; nothing where `id` is none of the jobs.
  std::optional<std::vector<SlurmJob>> After(const std::string& id) const;
};

/// Where a work folder keeps what concerns the cluster: work/slurm.
std::string SlurmFolder(const std::string& work);

/// Kept in work/slurm/jobs.json. Absent where that is missing or damaged.
std::optional<SlurmJobs> ReadSlurmJobs(const std::string& work);
void WriteSlurmJobs(const std::string& work, const SlurmJobs& jobs);
void ForgetSlurmJobs(const std::string& work);

/// How the final job ended.
struct SlurmResult {
  std::string job;
  int exit_code = 0;
  std::string summary;  ///< the line that a run ends with
};

/// Kept in work/slurm/result.json. Absent where that is missing, damaged, or of another job.
std::optional<SlurmResult> ReadSlurmResult(const std::string& work, const std::string& job);
void WriteSlurmResult(const std::string& work, const SlurmResult& result);
void ForgetSlurmResult(const std::string& work);

/// Throws FolderInUse that names the jobs where some of those of jobs.json are queued or running,
/// unless this process is the final one of them. Where Slurm cannot be asked and nothing says that
/// they have ended, it throws too, unless `force`.
void RequireNoJobs(const std::string& work, bool force, const ExecutionContext& context);

/// For the jobs of a submission: takes the lock of the work folder once whoever submits has freed
/// it. Throws FolderInUse where that takes more than a minute.
FolderLock LockWhenFree(const std::string& work, const ExecutionContext& context);

}  // namespace backsight
