#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "graph/plane_tree.h"

namespace backsight {

/// Keeps the plane tree alive that was used last, of all stations that share it, until another one
/// is wanted: those of dense scans are large. Pairs of one target follow one another, and those at
/// work keep theirs. Thread-safe.
class LastPlanes {
 public:
  void Use(std::shared_ptr<const PlaneTree> tree) {
    const std::lock_guard lock(mutex_);
    std::swap(tree_, tree);
  }  // the one before dies after the lock

  /// A new one; the last is gone before, where no pair is at work with it.
  std::shared_ptr<const PlaneTree> Make(const std::function<PlaneTree()>& make) {
    ForgetIdle();
    return std::make_shared<const PlaneTree>(make());
  }

 private:
  void ForgetIdle() {
    std::shared_ptr<const PlaneTree> idle;
    const std::lock_guard lock(mutex_);
    if (tree_.use_count() == 1) std::swap(tree_, idle);
  }

  std::mutex mutex_;
  std::shared_ptr<const PlaneTree> tree_;
};

}  // namespace backsight
