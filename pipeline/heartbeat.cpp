#include "pipeline/heartbeat.h"

#include <stop_token>
#include <utility>

namespace backsight {

Heartbeat::Heartbeat(std::function<void()> beat, std::chrono::milliseconds interval)
    : thread_([this, beat = std::move(beat), interval](const std::stop_token& stop) {
        std::unique_lock lock(mutex_);
        while (true) {
          stopped_.wait_for(lock, stop, interval, [] { return false; });
          if (stop.stop_requested()) return;
          beat();
        }
      }) {}

}  // namespace backsight
