#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "core/execution.h"

namespace backsight {

/// What a run knows of itself when its project has been read.
struct RunStart {
  std::string project;  ///< path of the project file
  std::string name;     ///< of the project
  std::string out;      ///< folder for results
  int stations = 0;
  int threads = 0;
  std::string options_fingerprint;  ///< equal for equal effective options
};

/// Writes every event as one line of JSON, as docs/schema/events.schema.json describes it. Bytes
/// that are not UTF-8 are replaced by U+FFFD.
class JsonEvents : public EventSink {
 public:
  /// Takes a line with its end; returns why it could not be written, empty if it was.
  using WriteLine = std::function<std::string(std::string_view)>;
  using Now = std::function<std::chrono::system_clock::time_point()>;

  /// How every line begins, whatever the version of the schema.
  static constexpr std::string_view kMark = "{\"schema_version\":";

  /// Once a line cannot be written, no more are, and `people` are warned of it.
  JsonEvents(WriteLine write, EventSink* people, Now now = &std::chrono::system_clock::now);

  void RunStarted(const RunStart& start);
  void RunInterrupted(int signal);
  void RunFinished(int exit_code, std::string_view verdict, double wall_s);

  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  void StageFinished(std::string_view stage, double seconds) override;

 private:
  struct Line;
  void Write(std::string_view event, const Line& line);

  const WriteLine write_;
  EventSink* const people_;
  const Now now_;
  std::mutex mutex_;  // of everything below, and of the order of lines
  bool broken_ = false;
  std::string stage_;
  std::size_t done_ = 0;
};

}  // namespace backsight
