#include "pipeline/work_queue.h"

#include <utility>

namespace backsight {

void WorkQueue::Add(const Order& order, std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  waiting_.emplace(order, std::move(work));
  if (spawn_ != nullptr) (*spawn_)([this] { RunFirst(); });
}

void WorkQueue::Clear() {
  const std::lock_guard lock(mutex_);
  waiting_.clear();
}

/// Every work has spawned one of these; which of them runs which work is decided only now.
void WorkQueue::RunFirst() {
  std::function<void()> work;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return;
    work = std::move(waiting_.extract(waiting_.begin()).mapped());
  }
  work();
}

void WorkQueue::Run() {
  try {
    context_.RunTasks([this](const ExecutionContext::Spawn& spawn) {
      const std::lock_guard lock(mutex_);
      spawn_ = &spawn;
      for (std::size_t i = 0; i < waiting_.size(); ++i) spawn([this] { RunFirst(); });
    });
  } catch (...) {
    End();
    throw;
  }
  End();
}

void WorkQueue::End() {
  const std::lock_guard lock(mutex_);
  spawn_ = nullptr;
  waiting_.clear();
}

}  // namespace backsight
