#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "pipeline/grouped_work.h"
#include "pipeline/stage_clock.h"
#include "pipeline/work_queue.h"

namespace backsight {
namespace {

TEST(WorkQueue, BeginsWithTheLargestOfTheHighestRank) {
  const ExecutionContext context(1);
  WorkQueue queue(context);
  std::vector<int> ran;
  const auto add = [&](int rank, double weight, int name) {
    queue.Add({.rank = rank, .weight = weight}, [&ran, name] { ran.push_back(name); });
  };
  add(0, 9.0, 1);
  add(1, 3.0, 2);
  add(1, 7.0, 3);
  add(1, 3.0, 4);
  add(0, 9.5, 5);
  queue.Run();
  EXPECT_EQ(ran, (std::vector<int>{3, 2, 4, 5, 1}));
}

TEST(WorkQueue, DoesWhatWorksAddInItsOrder) {
  const ExecutionContext context(1);
  WorkQueue queue(context);
  std::vector<int> ran;
  queue.Add({.rank = 1, .weight = 2.0}, [&] {
    ran.push_back(1);
    queue.Add({.rank = 0}, [&] { ran.push_back(3); });
  });
  queue.Add({.rank = 1, .weight = 1.0}, [&] { ran.push_back(2); });
  queue.Run();
  EXPECT_EQ(ran, (std::vector<int>{1, 2, 3}));
}

TEST(WorkQueue, ForgetsWhatIsNotBegun) {
  const ExecutionContext context(1);
  WorkQueue queue(context);
  int runs = 0;
  queue.Add({.rank = 1}, [&] { queue.Clear(), ++runs; });
  for (int i = 0; i < 5; ++i) queue.Add({}, [&] { runs += 10; });
  queue.Run();
  EXPECT_EQ(runs, 1);
  queue.Add({}, [&] { ++runs; });  // and can be used again
  queue.Run();
  EXPECT_EQ(runs, 2);
}

TEST(WorkQueue, RunsEverythingOnceOnManyThreads) {
  const ExecutionContext context(4);
  WorkQueue queue(context);
  std::vector<std::atomic<int>> runs(1000);
  for (std::size_t i = 0; i < 100; ++i) {
    queue.Add({.rank = 1, .weight = static_cast<double>(i * 37 % 100)}, [&, i] {
      ++runs[i];
      for (std::size_t k = 100 + i; k < runs.size(); k += 100) {
        queue.Add({.weight = static_cast<double>(k)}, [&, k] { ++runs[k]; });
      }
    });
  }
  queue.Run();
  for (const auto& count : runs) EXPECT_EQ(count, 1);
}

TEST(WorkQueue, RethrowsAndBeginsNothingMore) {
  const ExecutionContext context(1);
  WorkQueue queue(context);
  int runs = 0;
  queue.Add({.weight = 2.0}, [] { throw std::runtime_error("broken"); });
  queue.Add({.weight = 1.0}, [&] { ++runs; });
  EXPECT_THROW(queue.Run(), std::runtime_error);
  EXPECT_EQ(runs, 0);
  queue.Add({}, [&] { ++runs; });
  queue.Run();
  EXPECT_EQ(runs, 1) << "it forgot what it had not begun";
}

TEST(LargestGroupsFirst, GroupsStayTogetherAndThatOfTheLargestComesFirst) {
  std::vector<std::size_t> ran;
  // The largest of group 4 weighs 6, those of groups 7 and 2 weigh 5 each.
  LargestGroupsFirst({{7, 5.0}, {4, 2.0}, {2, 4.0}, {4, 6.0}, {2, 5.0}}, ExecutionContext(1),
                     [&](std::size_t i) { ran.push_back(i); });
  EXPECT_EQ(ran, (std::vector<std::size_t>{3, 1, 0, 4, 2}));
}

TEST(LargestGroupsFirst, RunsEverythingOnceOnManyThreads) {
  std::vector<std::atomic<int>> runs(1000);
  std::vector<GroupedWork> works;
  for (int i = 0; i < 1000; ++i) works.push_back({i % 7, i % 13 * 1.0});
  LargestGroupsFirst(works, ExecutionContext(4), [&](std::size_t i) { ++runs[i]; });
  for (const auto& count : runs) EXPECT_EQ(count, 1);
}

TEST(IdleShare, IsWhatNeitherRanNorWaited) {
  EXPECT_DOUBLE_EQ(IdleShare({3.0, 0.0}, 2.0, 2), 0.25);
  EXPECT_DOUBLE_EQ(IdleShare({3.0, 0.5}, 2.0, 2), 0.125);
  EXPECT_EQ(IdleShare({4.1, 0.0}, 2.0, 2), 0.0);  // clocks differ
  EXPECT_EQ(IdleShare({0.0, 0.0}, 0.0, 2), 0.0);
}

TEST(StageClock, TellsTheProcessorsTime) {
  std::vector<StageTime> times;
  const ExecutionContext context(1);
  StageClock clock(context, &times);
  const double begun_s = ReadProcessorUse().ran_s;
  while (ReadProcessorUse().ran_s - begun_s < 0.05) {
  }
  clock.Finish("busy");
  clock.Finish("nothing");
  ASSERT_EQ(times.size(), 2U);
  EXPECT_EQ(times[0].stage, "busy");
  EXPECT_GE(times[0].processor_s, 0.05);
  EXPECT_GE(times[0].seconds, 0.0);
  EXPECT_LT(times[1].processor_s, times[0].processor_s);
  for (const StageTime& time : times) {
    EXPECT_GE(time.idle_share, 0.0);
    EXPECT_LE(time.idle_share, 1.0);
  }
}

}  // namespace
}  // namespace backsight
