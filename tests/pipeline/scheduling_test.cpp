#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "pipeline/largest_first.h"
#include "pipeline/stage_clock.h"

namespace backsight {
namespace {

TEST(LargestFirst, BeginsWithTheLargestAndVisitsEachOnce) {
  const std::vector<double> weights{3.0, 9.0, 3.0, 0.0, 7.0};
  std::vector<std::size_t> order;
  LargestFirst(weights, ExecutionContext(1), [&](std::size_t i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<std::size_t>{1, 4, 0, 2, 3}));

  std::vector<double> many(1000);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<double>(i * 7919 % 1000);
  std::vector<std::atomic<int>> visits(many.size());
  LargestFirst(many, ExecutionContext(4), [&](std::size_t i) { ++visits[i]; });
  for (const auto& count : visits) EXPECT_EQ(count, 1);
}

TEST(LargestFirst, GroupsStayTogetherAndThatOfTheLargestComesFirst) {
  std::vector<std::size_t> ran;
  // The largest of group 4 weighs 6, those of groups 7 and 2 weigh 5 each.
  LargestGroupsFirst({{7, 5.0}, {4, 2.0}, {2, 4.0}, {4, 6.0}, {2, 5.0}}, ExecutionContext(1),
                     [&](std::size_t i) { ran.push_back(i); });
  EXPECT_EQ(ran, (std::vector<std::size_t>{3, 1, 0, 4, 2}));
}

TEST(LargestFirst, RunsEverythingOnceOnManyThreads) {
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
