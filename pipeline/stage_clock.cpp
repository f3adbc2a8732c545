#include "pipeline/stage_clock.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace backsight {
namespace {

namespace fs = std::filesystem;

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ProcessorUse ReadProcessorUse() {
  ProcessorUse use;
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) == 0) {
    use.ran_s = SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
  }
  std::error_code error;
  for (fs::directory_iterator task("/proc/self/task", error), end; !error && task != end;
       task.increment(error)) {
    std::ifstream file(task->path() / "schedstat");
    double ran_ns = 0.0;
    double waited_ns = 0.0;
    if (file >> ran_ns >> waited_ns) use.waited_s += 1e-9 * waited_ns;
  }
  return use;
}

double IdleShare(const ProcessorUse& used, double seconds, int threads) {
  const double offered_s = seconds * threads;
  if (!(offered_s > 0.0)) return 0.0;
  return std::clamp(1.0 - (used.ran_s + used.waited_s) / offered_s, 0.0, 1.0);
}

void StageClock::Finish(const std::string& stage) {
  const auto now = std::chrono::steady_clock::now();
  const ProcessorUse used = ReadProcessorUse();
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const ProcessorUse of_stage{used.ran_s - used_.ran_s,
                              std::max(0.0, used.waited_s - used_.waited_s)};
  times_->push_back(
      {stage, seconds, of_stage.ran_s, IdleShare(of_stage, seconds, context_.threads())});
  context_.StageFinished(stage, seconds);
  start_ = now;
  used_ = used;
}

}  // namespace backsight
