#include "pipeline/terminal_events.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace backsight {

TerminalEvents::TerminalEvents(Verbosity verbosity)
    : verbosity_(verbosity), is_terminal_(isatty(STDERR_FILENO) != 0) {}

void TerminalEvents::Message(Level level, std::string_view text) {
  if (level == Level::kDebug && verbosity_ != Verbosity::kVerbose) return;
  if (level == Level::kInfo && verbosity_ == Verbosity::kQuiet) return;
  const std::scoped_lock lock(mutex_);
  ClearLine();
  const char* prefix = level == Level::kWarning ? "warning: "
                       : level == Level::kError ? "error: "
                                                : "";
  fmt::print(stderr, "{}{}\n", prefix, text);
}

void TerminalEvents::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  if (verbosity_ == Verbosity::kQuiet) return;
  const std::scoped_lock lock(mutex_);
  if (stage != stage_ || done == 0) {
    stage_ = stage;
    shown_ = 0;
    stage_start_ = std::chrono::steady_clock::now();
  }
  if (done < shown_) return;  // a slower thread's older news
  shown_ = done;
  const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - stage_start_).count();
  if (done == total) {
    ClearLine();
    fmt::print(stderr, "{:<10} {:>5} of {:<5} {:6.1f} s\n", stage, done, total, elapsed);
  } else if (is_terminal_) {
    const double rest =
        done > 0 ? elapsed / static_cast<double>(done) * static_cast<double>(total - done) : 0.0;
    fmt::print(stderr, "\r{:<10} {:>5} of {:<5} {:6.1f} s, about {:.0f} s left ", stage, done,
               total, elapsed, rest);
    line_open_ = true;
  }
  std::fflush(stderr);
}

void TerminalEvents::ClearLine() {
  if (line_open_) fmt::print(stderr, "\r{:70}\r", "");
  line_open_ = false;
}

}  // namespace backsight
