#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include "core/execution.h"

namespace backsight {

/// Where text for people goes, and the clock they see.
struct Console {
  std::function<void(std::string_view)> write;  ///< what cannot be written is lost, not an error
  bool is_terminal = false;                     ///< a line can be written over
  std::function<std::chrono::steady_clock::time_point()> now;
};

/// stderr and the time of day.
Console StandardError();

/// Shows events to people: messages, and per stage k of N, rate, elapsed and remaining time. On a
/// terminal the line of the stage is rewritten in place; elsewhere a line is printed at the stage's
/// end, and every 30 s until then.
class TerminalEvents : public EventSink {
 public:
  enum class Verbosity { kQuiet, kNormal, kVerbose };  ///< quiet: warnings and errors only
  explicit TerminalEvents(Verbosity verbosity, Console console = StandardError());

  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  void StageFinished(std::string_view stage, double seconds) override;

  /// Brings what is shown of the stage up to date although none of its units has finished. To be
  /// called about once a second.
  void Tick();
  /// Takes the line of an unfinished stage away: nothing more will come of it.
  void Abandon();

 private:
  using Time = std::chrono::steady_clock::time_point;

  void BeginStage(std::string_view stage, std::size_t done, Time now);
  void EndStage(Time now);
  void ShowRunning(Time now, std::chrono::milliseconds rewrite_after);
  void PrintLine(std::string_view text);
  void ClearLine();
  std::string Text(Time now) const;

  const Verbosity verbosity_;
  const Console console_;
  std::mutex mutex_;  // of everything below
  std::string stage_;
  bool running_ = false;
  std::size_t done_ = 0, total_ = 0;
  std::size_t before_ = 0;  // done when the stage began
  Time stage_start_, last_shown_;
  bool line_open_ = false;
};

}  // namespace backsight
