#pragma once

#include <stop_token>

#include "pipeline/commands/commands.h"
#include "pipeline/run_events.h"

namespace backsight {

/// `run --executor slurm`: submits the run and prints the ids of its jobs, or follows them to their
/// end and returns the final job's exit code.
int RunOnSlurm(const RunArguments& arguments, const std::stop_token& stop, RunEvents* events);

}  // namespace backsight
