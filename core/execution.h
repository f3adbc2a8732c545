#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string_view>

namespace backsight {

/// Receives what people and machines want to see of a run. Implementations must be thread-safe.
class EventSink {
 public:
  enum class Level { kDebug, kInfo, kWarning, kError };
  virtual ~EventSink() = default;
  virtual void Message(Level level, std::string_view text) = 0;
  /// `done` of `total` units of `stage` are finished.
  virtual void Progress(std::string_view stage, std::size_t done, std::size_t total) = 0;
  /// A step of the run has ended. Its units, if it counts any, may bear other stages' names.
  virtual void StageFinished(std::string_view stage, double seconds) = 0;
};

/// What every stage is handed: threads, seed, events, stop request. Cheap to copy.
class ExecutionContext {
 public:
  /// `threads` 0 means all cores. `events` may be null and must outlive the context.
  explicit ExecutionContext(int threads = 1, std::uint64_t seed = 0, EventSink* events = nullptr,
                            std::stop_token stop = {});

  int threads() const;
  std::uint64_t seed() const { return seed_; }
  void Debug(std::string_view text) const { Send(EventSink::Level::kDebug, text); }
  void Info(std::string_view text) const { Send(EventSink::Level::kInfo, text); }
  void Warning(std::string_view text) const { Send(EventSink::Level::kWarning, text); }
  void Progress(std::string_view stage, std::size_t done, std::size_t total) const;
  void StageFinished(std::string_view stage, double seconds) const;

  /// Throws Interrupted if a stop was requested, OverTimeLimit if the time is over. Call it often
  /// enough that nobody waits for seconds.
  void CheckStop() const;

  /// The same context for one unit of work that may take `seconds` from now on; 0: any time.
  ExecutionContext WithTimeLimit(double seconds) const;

  /// Runs body(i) for every i in [0, n), on all threads of this context; nesting is allowed. Calls
  /// CheckStop as it goes. The first exception is rethrown. Results must go to place i, lest they
  /// depend on scheduling; `grain` indices at a time go to one thread.
  void ParallelFor(std::size_t n, const std::function<void(std::size_t)>& body,
                   std::size_t grain = 1) const;

  /// Takes a task, to be run by any thread.
  using Spawn = std::function<void(std::function<void()> task)>;
  /// Runs what `begin` spawns, and what those tasks spawn, on all threads, until all have ended.
  /// `spawn` may be used by any of them, but not after. Not within a loop or task. Calls CheckStop
  /// before every task. The first exception is rethrown; tasks not begun by then never are.
  void RunTasks(const std::function<void(const Spawn& spawn)>& begin) const;

  /// How many slots keep all threads of Stream busy.
  std::size_t StreamSlots() const;
  /// Passes work through `slots` (>= 1) places of the caller's, numbered from 0: `read` fills one
  /// after another until it returns false, `work` goes on side by side, and `write` takes them in
  /// the order of reading, one after another. Calls CheckStop before every read. The first
  /// exception is rethrown. With one slot, or one thread, everything happens in turn.
  void Stream(std::size_t slots, const std::function<bool(std::size_t slot)>& read,
              const std::function<void(std::size_t slot)>& work,
              const std::function<void(std::size_t slot)>& write) const;

 private:
  struct Arena;
  void Execute(const std::function<void()>& loop) const;
  void Send(EventSink::Level level, std::string_view text) const;

  std::shared_ptr<Arena> arena_;
  std::uint64_t seed_ = 0;
  EventSink* events_ = nullptr;
  std::stop_token stop_;
  double limit_s_ = 0.0;
  std::optional<std::chrono::steady_clock::time_point> deadline_;
};

}  // namespace backsight
