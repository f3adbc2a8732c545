#pragma once

#include <compare>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>

#include "core/execution.h"

namespace backsight {

/// Work for all threads that may grow while it is done: whichever thread is free takes what comes
/// first. So what becomes ready as something else ends need not wait until all of that has ended.
class WorkQueue {
 public:
  /// What comes first: the larger, by one member after the other; of equals, what was added first.
  struct Order {
    int rank = 0;
    double group_weight = 0.0;
    int group = 0;  ///< works of one group follow one another
    double weight = 0.0;
    auto operator<=>(const Order&) const = default;
  };

  explicit WorkQueue(const ExecutionContext& context) : context_(context) {}

  /// From any thread, before Run or by the works themselves.
  void Add(const Order& order, std::function<void()> work);
  /// Forgets what is not begun.
  void Clear();
  /// Does all work and what it adds, not within a task of the context. The first exception is
  /// rethrown; what is not begun then is forgotten.
  void Run();

 private:
  void RunFirst();
  void End();

  const ExecutionContext& context_;
  std::mutex mutex_;
  std::multimap<Order, std::function<void()>, std::greater<>> waiting_;
  const ExecutionContext::Spawn* spawn_ = nullptr;  // while it runs
};

}  // namespace backsight
