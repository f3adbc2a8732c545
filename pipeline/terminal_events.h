#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "core/execution.h"

namespace backsight {

/// Shows events to people on stderr: messages, and per stage k of N, elapsed and remaining time. On
/// a terminal the progress line is rewritten in place; elsewhere only a stage's end is printed.
class TerminalEvents : public EventSink {
 public:
  enum class Verbosity { kQuiet, kNormal, kVerbose };
  explicit TerminalEvents(Verbosity verbosity);

  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;

 private:
  void ClearLine();

  Verbosity verbosity_;
  bool is_terminal_;
  std::mutex mutex_;
  std::string stage_;
  std::size_t shown_ = 0;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point stage_start_;
};

}  // namespace backsight
