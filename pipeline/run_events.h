#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/execution.h"
#include "io/event_log_file.h"
#include "pipeline/heartbeat.h"
#include "pipeline/json_events.h"
#include "pipeline/terminal_events.h"

namespace backsight {

/// Forwards every event to several sinks, in their order.
class EventFanOut : public EventSink {
 public:
  explicit EventFanOut(std::vector<EventSink*> sinks);
  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  void StageFinished(std::string_view stage, double seconds) override;

 private:
  std::vector<EventSink*> sinks_;
};

/// Remembers what was warned of, so that it is not said twice.
class WarningMemory : public EventSink {
 public:
  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view /*stage*/, std::size_t /*done*/, std::size_t /*total*/) override {}
  void StageFinished(std::string_view /*stage*/, double /*seconds*/) override {}
  bool Holds(const std::string& warning) const;

 private:
  mutable std::mutex mutex_;
  std::set<std::string, std::less<>> warnings_;
};

/// The exit code of docs/conventions.md that an exception ends the program with.
int ExitCodeOf(const std::exception& error);

/// Tells the world of one run: people on stderr, an event log where one is wanted, and once the
/// pipeline was reached exactly one line on stdout, however the run ends. One of Finished,
/// Interrupted, Failed and End is to be called at the end; all but Failed return the exit code.
class RunEvents {
 public:
  /// `log_json`: the event log, empty for none. Throws InputError where it cannot be opened.
  RunEvents(TerminalEvents::Verbosity verbosity, const std::string& log_json);

  EventSink* sink() { return &all_; }
  /// The project has been read, and the pipeline begins.
  void Started(const RunStart& start);

  /// `verdict` goes to the log; stdout adds where the `report` is.
  int Finished(int exit_code, const std::string& verdict, const std::string& report);
  int Interrupted(int signal);
  /// For an exception that main will catch and report.
  void Failed(const std::exception& error);
  /// Any other end: stdout adds `more` to the verdict.
  int End(int exit_code, const std::string& verdict, const std::string& more);

  /// The line that the run ended with, and its exit code.
  const std::string& last_line() const { return last_line_; }
  int exit_code() const { return exit_code_; }

 private:
  std::vector<EventSink*> OpenLog(const std::string& path);

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool started_ = false;
  std::string last_line_;
  int exit_code_ = 0;
  TerminalEvents terminal_;
  std::optional<EventLogFile> file_;
  std::optional<JsonEvents> log_;
  EventFanOut all_;
  Heartbeat heartbeat_;  // last: it uses terminal_
};

}  // namespace backsight
