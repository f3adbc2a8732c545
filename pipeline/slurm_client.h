#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/execution.h"

namespace backsight {

/// A job, or an array of tasks, for Slurm.
struct SlurmRequest {
  std::string name;
  int tasks = 0;         ///< of an array, numbered from 0; 0: a single job
  std::string after;     ///< the job whose end it waits for, however that ends; empty: none
  std::string script;    ///< file that runs its arguments
  std::string log;       ///< where stdout and stderr go; Slurm fills in %A, %a, %j
  int threads = 0;       ///< CPUs per task; 0: as Slurm gives
  double memory_gb = 0;  ///< budget of the program; the job asks for a quarter more
  std::vector<std::string> options;  ///< of the user; they come last, so that they win
  std::vector<std::string> command;  ///< the program and its arguments
};

/// Slurm does not answer now, or one of its commands not within a minute; it may later.
class SlurmUnreachable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Submits by sbatch and returns the job's id. Throws InputError where there is no sbatch or it
/// refuses the job, with what it said, and SlurmUnreachable where the controller does not answer.
/// A stop that `context` requests, here and below, ends the command and throws Interrupted.
std::string SubmitJob(const SlurmRequest& request, const ExecutionContext& context);

/// Cancels jobs, whatever stop is requested; none that has ended is a fault. Throws
/// SlurmUnreachable where scancel does not do it.
void CancelJobs(const std::vector<std::string>& ids);

/// Has a pending job wait for the end of another one instead of what it waits for now. Throws
/// SlurmUnreachable where scontrol does not do it.
void MakeJobWait(const std::string& job, const std::string& after, const ExecutionContext& context);

/// A job, or a task of an array, that has not ended.
struct QueuedJob {
  std::string id;     ///< of an array's task: the array's
  std::string state;  ///< PENDING, RUNNING, ...
};

/// Those of the jobs that have not ended, one entry per task. Throws SlurmUnreachable where squeue
/// cannot be asked, with what it said.
std::vector<QueuedJob> QueuedJobs(const std::vector<std::string>& ids,
                                  const ExecutionContext& context);

/// The CPUs that Slurm gave to the task this process runs in; absent outside of tasks.
std::optional<int> TaskCpus();

/// The job this process runs in, empty outside of jobs.
std::string OwnJob();

/// A path with every % doubled: Slurm fills in patterns in paths.
std::string EscapePattern(const std::string& path);

}  // namespace backsight
