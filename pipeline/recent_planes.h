#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "graph/plane_tree.h"

namespace backsight {

/// Keeps the plane trees of all stations alive that were used last: those of dense scans are large,
/// and pairs of one target follow one another. Thread-safe.
class RecentPlanes {
 public:
  explicit RecentPlanes(std::size_t most) : most_(most) {}

  void Use(std::shared_ptr<const PlaneTree> tree) {
    std::shared_ptr<const PlaneTree> oldest;  // dies outside the lock
    const std::lock_guard lock(mutex_);
    std::erase(trees_, tree);
    trees_.push_back(std::move(tree));
    if (trees_.size() <= most_) return;
    oldest = std::move(trees_.front());
    trees_.pop_front();
  }

 private:
  std::size_t most_;
  std::mutex mutex_;
  std::deque<std::shared_ptr<const PlaneTree>> trees_;  // the one used last is last
};

}  // namespace backsight
