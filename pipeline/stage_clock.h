#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/run_records.h"

namespace backsight {

/// What the system has given this process so far, seconds over all its threads.
struct ProcessorUse {
  double ran_s = 0.0;
  double waited_s = 0.0;  ///< ready to run while others had the cores; 0 where it does not say
};
ProcessorUse ReadProcessorUse();

/// Share of `threads` * `seconds` in which no thread ran or waited for a core, 0 to 1: work was
/// lacking, or its data. `used` is that of the time only.
double IdleShare(const ProcessorUse& used, double seconds, int threads);

/// Measures the stages of a run one after another; the times go to the manifest and events only.
class StageClock {
 public:
  StageClock(const ExecutionContext& context, std::vector<StageTime>* times)
      : context_(context), times_(times) {}
  /// What has passed since the last call was `stage`.
  void Finish(const std::string& stage);

 private:
  const ExecutionContext& context_;
  std::vector<StageTime>* times_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  ProcessorUse used_ = ReadProcessorUse();
};

}  // namespace backsight
