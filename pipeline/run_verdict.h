#pragma once

#include <vector>

#include "io/run_records.h"
#include "io/survey_project.h"

namespace backsight {

/// How a run went beyond what its records say.
struct Completion {
  int failed_pairs = 0;   ///< of whose attempts one at least did not come to its end
  bool converged = true;  ///< the adjustment of the network
};

/// The gates that the project asks for, and that control does not contradict itself. What cannot be
/// judged has failed.
std::vector<GateRecord> JudgeGates(const GateSpec& gates, const std::vector<PoseRecord>& poses,
                                   const std::vector<GeoreferenceRecord>& georeference);

/// Sets verdict and exit code from the run's poses, gates and georeference. A failed gate outranks
/// a partial result: it was asked for.
void Judge(const Completion& completion, RunRecord* run);

}  // namespace backsight
