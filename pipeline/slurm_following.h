#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/execution.h"
#include "pipeline/run_plan.h"
#include "pipeline/slurm_jobs.h"

namespace backsight {

/// Follows the jobs until the final one has ended, and tells `context` how far they are: by `plan`
/// (what is up to date now), then by what the final run tells; that Slurm does not answer for
/// minutes is a warning. Nothing where the final job ended without a result. Throws Interrupted
/// when a stop is requested; the jobs go on then.
std::optional<SlurmResult> FollowJobs(const SlurmJobs& jobs, const std::string& work,
                                      const std::function<RunPlan()>& plan,
                                      const ExecutionContext& context);

}  // namespace backsight
