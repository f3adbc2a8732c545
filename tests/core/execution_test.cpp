#include "core/execution.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"

namespace backsight {
namespace {

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const int threads : {1, 4}) {
    const ExecutionContext context(threads);
    EXPECT_EQ(context.threads(), threads);
    for (const std::size_t n : {0U, 1U, 7U, 1000U}) {
      for (const std::size_t grain : {1U, 3U, 64U}) {
        std::vector<std::atomic<int>> visits(n);
        context.ParallelFor(
            n, [&](std::size_t i) { ++visits[i]; }, grain);
        for (const auto& count : visits) ASSERT_EQ(count, 1) << n << " " << grain;
      }
    }
  }
}

TEST(ParallelFor, UsesSeveralThreads) {
  const ExecutionContext context(4);
  std::atomic<int> inside = 0;
  std::atomic<bool> met = false;
  context.ParallelFor(2, [&](std::size_t) {
    ++inside;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (inside < 2 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    if (inside == 2) met = true;
  });
  EXPECT_TRUE(met) << "two bodies never ran at the same time";
}

TEST(ParallelFor, OneThreadRunsInOrder) {
  const ExecutionContext context(1);
  std::vector<std::size_t> order;
  context.ParallelFor(100, [&](std::size_t i) { order.push_back(i); });
  ASSERT_EQ(order.size(), 100U);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

/// What comes out of Stream when 200 numbers go in, and how often several were worked on at once.
std::vector<int> Streamed(const ExecutionContext& context, std::size_t slots, int* met) {
  std::vector<int> values(slots, -1);
  std::vector<int> written;
  std::atomic<int> inside = 0;
  std::atomic<int> meetings = 0;
  int next = 0;
  context.Stream(
      slots,
      [&](std::size_t slot) {
        EXPECT_EQ(values[slot], -1) << "a slot that is in use";
        if (next == 200) return false;
        values[slot] = next++;
        return true;
      },
      [&](std::size_t slot) {
        if (++inside > 1) ++meetings;
        std::this_thread::sleep_for(std::chrono::microseconds(values[slot] % 7 * 100));
        values[slot] *= 2;
        --inside;
      },
      [&](std::size_t slot) {
        written.push_back(values[slot]);
        values[slot] = -1;
      });
  *met = meetings;
  return written;
}

TEST(Stream, KeepsTheOrderOfReading) {
  std::vector<int> expected;
  for (int i = 0; i < 200; ++i) expected.push_back(2 * i);
  for (const int threads : {1, 2, 4}) {
    const ExecutionContext context(threads);
    for (const std::size_t slots : {std::size_t{1}, std::size_t{3}, context.StreamSlots()}) {
      int met = 0;
      EXPECT_EQ(Streamed(context, slots, &met), expected) << threads << " " << slots;
      if (threads == 1 || slots == 1) {
        EXPECT_EQ(met, 0);
      } else {
        EXPECT_GT(met, 0) << threads << " threads never worked side by side";
      }
    }
  }
}

TEST(Stream, PassesOnWhatIsThrownAndStopsWhereAsked) {
  const ExecutionContext context(2);
  const auto nothing = [](std::size_t) {};
  const auto forever = [](std::size_t) { return true; };
  const auto fail = [](std::size_t) { throw std::runtime_error("broken"); };
  EXPECT_THROW(context.Stream(4, forever, fail, nothing), std::runtime_error);
  EXPECT_THROW(context.Stream(4, forever, nothing, fail), std::runtime_error);
  std::stop_source source;
  const ExecutionContext stopped(2, 0, nullptr, source.get_token());
  int reads = 0;
  const auto read = [&](std::size_t) {
    if (++reads == 10) source.request_stop();
    return true;
  };
  EXPECT_THROW(stopped.Stream(4, read, nothing, nothing), Interrupted);
  EXPECT_EQ(reads, 10);
}

TEST(ParallelFor, EndsWhereAStopIsRequested) {
  std::stop_source source;
  const ExecutionContext context(1, 0, nullptr, source.get_token());
  int done = 0;
  const auto body = [&](std::size_t) {
    if (++done == 3) source.request_stop();
  };
  EXPECT_THROW(context.ParallelFor(100, body), Interrupted);
  EXPECT_EQ(done, 3);
}

TEST(ParallelFor, RethrowsAndStaysUsable) {
  for (const int threads : {1, 4}) {
    const ExecutionContext context(threads);
    const auto fail = [](std::size_t i) {
      if (i == 57) throw std::invalid_argument("fifty-seven");
    };
    try {
      context.ParallelFor(100, fail);
      FAIL() << "the exception was swallowed";
    } catch (const std::invalid_argument& error) {
      EXPECT_STREQ(error.what(), "fifty-seven");
    }
    std::atomic<int> visits = 0;
    context.ParallelFor(10, [&](std::size_t) { ++visits; });
    EXPECT_EQ(visits, 10);
  }
}

TEST(ParallelFor, Nests) {
  for (const int threads : {1, 4}) {
    const ExecutionContext context(threads);
    constexpr std::size_t kOuter = 9;
    constexpr std::size_t kInner = 31;
    std::vector<std::atomic<int>> visits(kOuter * kInner);
    context.ParallelFor(kOuter, [&](std::size_t i) {
      context.ParallelFor(kInner, [&](std::size_t j) { ++visits[i * kInner + j]; });
    });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
  }
}

/// Waits until `count` has come to `wanted`, but not for ever.
bool Reaches(const std::atomic<int>& count, int wanted) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (count < wanted && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  return count >= wanted;
}

TEST(ParallelFor, WhoWaitsForTheOutermostLoopHelpsWithNestedOnes) {
  const ExecutionContext context(2);
  const auto caller = std::this_thread::get_id();
  std::atomic<int> outside = 0;
  std::atomic<int> inside = 0;
  std::atomic<bool> met = false;
  context.ParallelFor(2, [&](std::size_t) {
    ++outside;
    ASSERT_TRUE(Reaches(outside, 2)) << "both threads have a body";
    if (std::this_thread::get_id() == caller) return;
    context.ParallelFor(2, [&](std::size_t) {
      ++inside;
      if (Reaches(inside, 2)) met = true;
    });
  });
  EXPECT_TRUE(met) << "the caller left the other thread alone";
}

TEST(RunTasks, RunsWhatTasksSpawnAndWhatTheySpawn) {
  for (const int threads : {1, 4}) {
    const ExecutionContext context(threads);
    std::atomic<int> runs = 0;
    context.RunTasks([&](const ExecutionContext::Spawn& spawn) {
      for (int i = 0; i < 20; ++i) {
        spawn([&] {
          ++runs;
          context.ParallelFor(5, [&](std::size_t) { ++runs; });
          spawn([&] { spawn([&] { ++runs; }); });
        });
      }
    });
    EXPECT_EQ(runs, 20 * 7);
  }
}

TEST(RunTasks, RethrowsWhateverThrewAndStaysUsable) {
  for (const int threads : {1, 4}) {
    const ExecutionContext context(threads);
    const auto fail = [] { throw std::runtime_error("broken"); };
    using Spawn = ExecutionContext::Spawn;
    EXPECT_THROW(context.RunTasks([&](const Spawn& spawn) { spawn(fail); }), std::runtime_error);
    EXPECT_THROW(context.RunTasks([&](const Spawn& spawn) { spawn([&] { spawn(fail); }); }),
                 std::runtime_error);
    EXPECT_THROW(context.RunTasks([&](const Spawn& spawn) {
      spawn([] {});
      fail();
    }),
                 std::runtime_error);
    int runs = 0;
    context.RunTasks([&](const Spawn& spawn) { spawn([&] { ++runs; }); });
    EXPECT_EQ(runs, 1);
  }
}

TEST(RunTasks, EndsWhereAStopIsRequested) {
  std::stop_source stop;
  const ExecutionContext context(2, 0, nullptr, stop.get_token());
  std::atomic<int> runs = 0;
  const std::function<void(const ExecutionContext::Spawn&)> go_on =
      [&](const ExecutionContext::Spawn& spawn) {
        if (++runs == 10) stop.request_stop();
        spawn([&] { go_on(spawn); });
      };
  EXPECT_THROW(context.RunTasks(go_on), Interrupted);
}

TEST(ParallelFor, ResultsDoNotDependOnThreads) {
  const auto run = [](int threads) {
    const ExecutionContext context(threads);
    std::vector<double> results(5000);
    context.ParallelFor(
        results.size(), [&](std::size_t i) { results[i] = std::sin(static_cast<double>(i)) / 3.0; },
        16);
    return results;
  };
  EXPECT_EQ(run(1), run(4));
}

TEST(ExecutionContext, ZeroThreadsMeansAllCores) {
  EXPECT_EQ(ExecutionContext(0).threads(),
            static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
}

TEST(ExecutionContext, StopRequestInterrupts) {
  std::stop_source source;
  const ExecutionContext context(1, 0, nullptr, source.get_token());
  EXPECT_NO_THROW(context.CheckStop());
  source.request_stop();
  EXPECT_THROW(context.CheckStop(), Interrupted);
  EXPECT_THROW(context.ParallelFor(4, [&](std::size_t) { context.CheckStop(); }), Interrupted);
  EXPECT_NO_THROW(ExecutionContext().CheckStop());
}

class Recorder : public EventSink {
 public:
  void Message(Level level, std::string_view text) override {
    messages.emplace_back(level, std::string(text));
  }
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override {
    progress = std::string(stage) + " " + std::to_string(done) + "/" + std::to_string(total);
  }
  void StageFinished(std::string_view stage, double seconds) override {
    finished = std::string(stage) + " " + std::to_string(seconds);
  }
  std::vector<std::pair<Level, std::string>> messages;
  std::string progress, finished;
};

TEST(ExecutionContext, PassesEventsOn) {
  Recorder recorder;
  const ExecutionContext context(1, 42, &recorder);
  const ExecutionContext copy = context;
  EXPECT_EQ(copy.seed(), 42U);
  copy.Debug("d");
  copy.Info("i");
  copy.Warning("w");
  copy.Progress("matching", 3, 7);
  copy.StageFinished("pairs", 1.5);
  using Level = EventSink::Level;
  const std::vector<std::pair<Level, std::string>> expected = {
      {Level::kDebug, "d"}, {Level::kInfo, "i"}, {Level::kWarning, "w"}};
  EXPECT_EQ(recorder.messages, expected);
  EXPECT_EQ(recorder.progress, "matching 3/7");
  EXPECT_EQ(recorder.finished, "pairs 1.500000");
  EXPECT_NO_THROW(ExecutionContext().Warning("nobody listens"));
}

}  // namespace
}  // namespace backsight
