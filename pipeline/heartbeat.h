#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace backsight {

/// Calls `beat` every `interval` from a thread of its own, first after one interval, until it is
/// destroyed; that waits for a call that is going on, never for the interval. `beat` must not throw
/// and must outlive the object.
class Heartbeat {
 public:
  explicit Heartbeat(std::function<void()> beat,
                     std::chrono::milliseconds interval = std::chrono::seconds(1));

 private:
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::jthread thread_;  // last: it uses the others, and is stopped and joined before they go
};

}  // namespace backsight
