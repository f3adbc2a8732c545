#include "pipeline/terminal_events.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "pipeline/progress_text.h"

namespace backsight {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPlainInterval = std::chrono::seconds(30);
constexpr milliseconds kRewriteInterval(100);  // faster than anyone reads
constexpr std::string_view kEraseLine = "\r\x1b[K";

bool CanRewriteLines() {
  const char* kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && kind != nullptr && std::string_view(kind) != "dumb";
}

}  // namespace

Console StandardError() {
  return {.write =
              [](std::string_view text) {
                std::fwrite(text.data(), 1, text.size(), stderr);
                std::fflush(stderr);
              },
          .is_terminal = CanRewriteLines(),
          .now = &std::chrono::steady_clock::now};
}

TerminalEvents::TerminalEvents(Verbosity verbosity, Console console)
    : verbosity_(verbosity), console_(std::move(console)) {}

void TerminalEvents::Message(Level level, std::string_view text) {
  if (level == Level::kDebug && verbosity_ != Verbosity::kVerbose) return;
  if (level == Level::kInfo && verbosity_ == Verbosity::kQuiet) return;
  const char* prefix = level == Level::kWarning ? "warning: "
                       : level == Level::kError ? "error: "
                                                : "";
  const std::scoped_lock lock(mutex_);
  PrintLine(prefix + std::string(text));
}

void TerminalEvents::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  if (verbosity_ == Verbosity::kQuiet) return;
  const std::scoped_lock lock(mutex_);
  const Time now = console_.now();
  if (stage != stage_ || done == 0) BeginStage(stage, done, now);
  if (done < done_) return;  // a slower thread's older news
  done_ = done;
  total_ = total;
  if (done == total) {
    EndStage(now);
  } else {
    running_ = true;
    ShowRunning(now, kRewriteInterval);
  }
}

void TerminalEvents::StageFinished(std::string_view stage, double seconds) {
  if (verbosity_ == Verbosity::kQuiet) return;
  const std::scoped_lock lock(mutex_);
  if (stage != stage_) {
    PrintLine(StageText(stage, seconds));
  } else if (running_) {
    EndStage(console_.now());
  }
}

void TerminalEvents::Tick() {
  const std::scoped_lock lock(mutex_);
  if (running_) ShowRunning(console_.now(), milliseconds(0));
}

void TerminalEvents::Abandon() {
  const std::scoped_lock lock(mutex_);
  ClearLine();
  running_ = false;
}

void TerminalEvents::BeginStage(std::string_view stage, std::size_t done, Time now) {
  stage_ = stage;
  done_ = before_ = done;
  stage_start_ = now;
  last_shown_ = now;
}

void TerminalEvents::EndStage(Time now) {
  PrintLine(Text(now));
  running_ = false;
}

void TerminalEvents::ShowRunning(Time now, milliseconds rewrite_after) {
  if (!console_.is_terminal) {
    if (now - last_shown_ < kPlainInterval) return;
    PrintLine(Text(now));
  } else {
    if (line_open_ && now - last_shown_ < rewrite_after) return;
    console_.write(std::string(kEraseLine) + Text(now));
    line_open_ = true;
  }
  last_shown_ = now;
}

void TerminalEvents::PrintLine(std::string_view text) {
  ClearLine();
  console_.write(std::string(text) + "\n");
}

void TerminalEvents::ClearLine() {
  if (line_open_) console_.write(kEraseLine);
  line_open_ = false;
}

std::string TerminalEvents::Text(Time now) const {
  return ProgressText(stage_, done_, total_,
                      std::chrono::duration<double>(now - stage_start_).count(), before_);
}

}  // namespace backsight
