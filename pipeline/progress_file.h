#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>

#include "core/execution.h"

namespace backsight {

/// How far a run is.
struct RunProgress {
  std::string stage;
  std::size_t done = 0;
  std::size_t total = 0;
};

/// Keeps a run's progress in `folder`/progress.json for other processes, at most once a second.
/// Where it cannot be written, nothing happens: the run is worth more.
class ProgressFile : public EventSink {
 public:
  /// Removes what an earlier run has left.
  explicit ProgressFile(const std::string& folder);

  void Message(Level level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  void StageFinished(std::string_view stage, double seconds) override;

  /// Where the run is: "pairs", "after pairs", or "start".
  std::string place() const;

 private:
  std::string path_;
  mutable std::mutex mutex_;
  std::string stage_;  // the last that counted units
  std::string place_ = "start";
  std::optional<std::chrono::steady_clock::time_point> written_;
};

/// What is kept in the folder; nothing where that is missing or damaged.
std::optional<RunProgress> ReadProgress(const std::string& folder);

}  // namespace backsight
