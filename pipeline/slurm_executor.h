#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "pipeline/slurm_jobs.h"

namespace backsight {

/// A run for the cluster. Paths may be relative to the folder of this process.
struct SlurmSubmission {
  std::string project;
  std::string out;
  std::string work;
  int threads = 0;                       ///< of every job; 0: as Slurm gives
  double memory_gb = 0;                  ///< budget of every job
  std::string options;                   ///< more options of sbatch
  std::vector<std::string> final_words;  ///< more arguments of the final run
};

/// Submits, each to begin when the one before has ended, however that went: an array with a task
/// per station, an array of `shards` tasks that share the pairs, and the final run, which does
/// whatever is left (docs/cluster.md). Where `shards` is 0 the pairs are found in rounds: a
/// coordinator stands in the array's place. jobs.json is kept up to date throughout. If one is
/// refused, or a stop is requested, those before it are cancelled; where Slurm does not do that, a
/// warning names them and they stay in jobs.json. Throws as SubmitJob and
/// SbatchOptions do. The caller holds the lock of the work folder.
SlurmJobs SubmitSurvey(const SlurmSubmission& submission, int stations, int shards,
                       const ExecutionContext& context);

/// For a coordinator, which is the job `own`: the jobs of its run, where it has a round to begin.
/// Nothing where the final job does not wait any more, or where this coordinator has begun its
/// round before, when Slurm started it the last time; what lacks of that round is submitted then.
/// The caller holds the lock of the work folder from here on until the round is submitted.
std::optional<SlurmJobs> JobsToContinue(const SlurmSubmission& submission, const std::string& own,
                                        const ExecutionContext& context);

/// Submits an array of `shards` tasks that make the attempts of the stored batch, and the next
/// coordinator; the final job waits for each as soon as it is there. `jobs`: those of the run.
/// `done`: attempts that are stored so far.
void SubmitRound(const SlurmSubmission& submission, const SlurmJobs& jobs, int shards,
                 std::size_t done, const ExecutionContext& context);

}  // namespace backsight
