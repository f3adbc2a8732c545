#include "core/execution.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "core/error.h"

namespace backsight {

struct ExecutionContext::Arena {
  // TBB offers one thread per core; global_control lets tests ask for more threads than cores.
  explicit Arena(int threads)
      : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads) {}
  tbb::global_control limit;
  tbb::task_arena arena;
};

namespace {

/// Whether this thread is at a task of some loop.
thread_local bool in_task = false;

class InTask {
 public:
  InTask() : before_(std::exchange(in_task, true)) {}
  ~InTask() { in_task = before_; }
  InTask(const InTask&) = delete;
  InTask& operator=(const InTask&) = delete;

 private:
  bool before_;
};

}  // namespace

ExecutionContext::ExecutionContext(int threads, std::uint64_t seed, EventSink* events,
                                   std::stop_token stop)
    : seed_(seed), events_(events), stop_(std::move(stop)) {
  if (threads <= 0) threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  arena_ = std::make_shared<Arena>(threads);
}

int ExecutionContext::threads() const { return arena_->arena.max_concurrency(); }

void ExecutionContext::Progress(std::string_view stage, std::size_t done, std::size_t total) const {
  if (events_ != nullptr) events_->Progress(stage, done, total);
}

void ExecutionContext::StageFinished(std::string_view stage, double seconds) const {
  if (events_ != nullptr) events_->StageFinished(stage, seconds);
}

void ExecutionContext::CheckStop() const {
  if (stop_.stop_requested()) throw Interrupted();
  if (deadline_ && std::chrono::steady_clock::now() > *deadline_) {
    throw OverTimeLimit(fmt::format("took longer than its limit of {:g} s", limit_s_));
  }
}

ExecutionContext ExecutionContext::WithTimeLimit(double seconds) const {
  ExecutionContext limited = *this;
  if (seconds <= 0.0) return limited;
  limited.limit_s_ = seconds;
  limited.deadline_ = std::chrono::steady_clock::now() +
                      std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                          std::chrono::duration<double>(seconds));
  return limited;
}

/// A nested loop is isolated: whoever waits for it takes up none of the outer loop's work
/// meanwhile, whose time and memory would count as its own. The outermost is not: who waits for it
/// has nothing else to do, and helps with the loops nested in it.
void ExecutionContext::Execute(const std::function<void()>& loop) const {
  arena_->arena.execute([&] {
    if (in_task) {
      tbb::this_task_arena::isolate(loop);
    } else {
      loop();
    }
  });
}

void ExecutionContext::ParallelFor(std::size_t n, const std::function<void(std::size_t)>& body,
                                   std::size_t grain) const {
  Execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, n, grain),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const InTask mark;
          CheckStop();
          for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
}

void ExecutionContext::RunTasks(const std::function<void(const Spawn& spawn)>& begin) const {
  BACKSIGHT_CHECK(!in_task, "what is spawned within nested loops would not be waited for");
  Execute([&] {
    tbb::task_group group;
    const Spawn spawn = [&](std::function<void()> task) {
      group.run([this, task = std::move(task)] {
        const InTask mark;
        CheckStop();
        task();
      });
    };
    // In a task of its own, so that what it throws ends the group as what the others throw.
    group.run_and_wait([&] {
      const InTask mark;
      CheckStop();
      begin(spawn);
    });
  });
}

std::size_t ExecutionContext::StreamSlots() const {
  constexpr std::size_t kAhead = 2;  // read and not yet begun, or done and not yet written
  constexpr std::size_t kMost = 16;  // one thread reads: it keeps no more of them busy
  const auto threads = static_cast<std::size_t>(this->threads());
  return threads == 1 ? 1 : std::min(threads + kAhead, kMost);
}

void ExecutionContext::Stream(std::size_t slots, const std::function<bool(std::size_t)>& read,
                              const std::function<void(std::size_t)>& work,
                              const std::function<void(std::size_t)>& write) const {
  // Tokens leave in the order in which they came, so that of `slots` tokens at most the one that
  // used a slot before has left when it is used again.
  std::size_t next = 0;
  const auto source = [&](tbb::flow_control& flow) {
    const InTask mark;
    CheckStop();
    const std::size_t slot = next++ % slots;
    if (!read(slot)) flow.stop();
    return slot;
  };
  const auto pass_on = [&](std::size_t slot) {
    const InTask mark;
    work(slot);
    return slot;
  };
  const auto sink = [&](std::size_t slot) {
    const InTask mark;
    write(slot);
  };
  Execute([&] {
    tbb::parallel_pipeline(
        slots, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, source) &
                   tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, pass_on) &
                   tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, sink));
  });
}

void ExecutionContext::Send(EventSink::Level level, std::string_view text) const {
  if (events_ != nullptr) events_->Message(level, text);
}

}  // namespace backsight
