#include "graph/interval_stabbing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// An interval of angles in radians, at most a full turn.
struct AngleInterval {
  double begin = 0.0;
  double end = 0.0;
  std::uint32_t id = 0;
};

TurnArc ArcOf(const AngleInterval& interval) {
  if (interval.end - interval.begin >= kTurn) return {0.0, kFullTurn, interval.id};
  const auto turn = [](double angle) {
    const double t = TurnOf(std::cos(angle), std::sin(angle));
    return t >= kFullTurn ? 0.0 : t;
  };
  TurnArc arc{turn(interval.begin), turn(interval.end), interval.id};
  if (arc.end < arc.begin) arc.end += kFullTurn;
  return arc;
}

constexpr RotationSectors::Run kAllRound{0, RotationSectors::kCount};

StabbingResult StabIntervals(const std::vector<AngleInterval>& intervals,
                             std::span<const RotationSectors::Run> runs = {&kAllRound, 1}) {
  std::size_t ids = 0;
  std::vector<TurnArc> arcs;
  for (const AngleInterval& interval : intervals) {
    ids = std::max<std::size_t>(ids, interval.id + 1);
    arcs.push_back(ArcOf(interval));
  }
  return IntervalStabber(ids).Stab(arcs, runs);
}

bool Covers(const AngleInterval& interval, double angle) {
  if (interval.end - interval.begin >= kTurn) return true;
  constexpr double kRounding = 1e-12;
  const double offset = angle - interval.begin + kRounding;
  return offset - kTurn * std::floor(offset / kTurn) <=
         interval.end - interval.begin + 2.0 * kRounding;
}

int CountAt(const std::vector<AngleInterval>& intervals, double angle) {
  std::set<std::uint32_t> ids;
  for (const AngleInterval& interval : intervals) {
    if (Covers(interval, angle)) ids.insert(interval.id);
  }
  return static_cast<int>(ids.size());
}

std::vector<AngleInterval> RandomIntervals(Random& random, int n, double longest, int ids) {
  std::vector<AngleInterval> intervals;
  for (int i = 0; i < n; ++i) {
    const double begin = random.Uniform(-kTurn, 2.0 * kTurn);
    intervals.push_back({begin, begin + random.Uniform(0.01, longest),
                         static_cast<std::uint32_t>(random.Index(static_cast<unsigned>(ids)))});
  }
  return intervals;
}

TEST(StabIntervals, EqualsADenseScan) {
  Random random(1);
  for (int round = 0; round < 12; ++round) {
    const int n = 3 + 3 * round;
    const auto intervals = RandomIntervals(random, n, round % 3 == 0 ? 7.0 : 0.8, n / 2 + 1);
    int scanned = 0;
    constexpr int kSteps = 100000;
    for (int i = 0; i < kSteps; ++i) {
      scanned = std::max(scanned, CountAt(intervals, kTurn * i / kSteps));
    }
    const StabbingResult best = StabIntervals(intervals);
    // The scan may miss a segment narrower than its step, never the other way round.
    EXPECT_GE(best.count, scanned);
    EXPECT_EQ(CountAt(intervals, best.angle), best.count);
    EXPECT_GE(best.angle, 0.0);
    EXPECT_LT(best.angle, kTurn);
  }
}

TEST(StabIntervals, NothingToStab) { EXPECT_EQ(StabIntervals({}).count, 0); }

TEST(StabIntervals, ReturnsTheMiddleOfTheBestSegment) {
  const std::vector<AngleInterval> intervals = {{0.5, 2.0, 1}, {1.0, 3.0, 2}, {2.5, 4.0, 3}};
  const StabbingResult best = StabIntervals(intervals);
  EXPECT_EQ(best.count, 2);
  EXPECT_NEAR(best.angle, 1.5, 1e-12);
}

TEST(StabIntervals, WrapsAround) {
  const std::vector<AngleInterval> intervals = {{-0.2, 0.4, 1}, {kTurn - 0.4, kTurn + 0.2, 2}};
  const StabbingResult best = StabIntervals(intervals);
  EXPECT_EQ(best.count, 2);
  EXPECT_NEAR(std::remainder(best.angle, kTurn), 0.0, 1e-12) << "middle of [-0.2, 0.2]";
}

TEST(StabIntervals, TurnsWithItsIntervals) {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    auto intervals = RandomIntervals(random, 6, 1.5, 6);
    for (std::uint32_t i = 0; i < intervals.size(); ++i) intervals[i].id = i;
    intervals.push_back({1.0, 1.8, 100});
    // A cluster that makes the best segment unique.
    for (std::uint32_t i = 0; i < 20; ++i) {
      intervals.push_back({1.2 - 0.01 * i, 1.3 + 0.01 * i, 200 + i});
    }
    const StabbingResult before = StabIntervals(intervals);
    const double turn = random.Uniform(-10.0, 10.0);
    for (AngleInterval& interval : intervals) interval.begin += turn, interval.end += turn;
    const StabbingResult after = StabIntervals(intervals);
    ASSERT_EQ(after.count, before.count);
    ASSERT_EQ(CountAt(intervals, after.angle), after.count);
  }
}

TEST(StabIntervals, MiddleTurnsAcrossTheCut) {
  for (double turn = 0.0; turn < kTurn; turn += 0.1) {
    const std::vector<AngleInterval> intervals = {{turn - 0.3, turn + 0.3, 1},
                                                  {turn - 0.2, turn + 0.4, 2}};
    const StabbingResult best = StabIntervals(intervals);
    EXPECT_EQ(best.count, 2);
    EXPECT_NEAR(std::remainder(best.angle - turn - 0.05, kTurn), 0.0, 1e-12) << turn;
  }
}

TEST(StabIntervals, TouchingEndsCountTogether) {
  const std::vector<AngleInterval> inside = {{1.0, 2.0, 1}, {2.0, 3.0, 2}};
  EXPECT_EQ(StabIntervals(inside).count, 2);
  EXPECT_NEAR(StabIntervals(inside).angle, 2.0, 1e-12);
  const std::vector<AngleInterval> at_the_cut = {{-0.5, 0.0, 1}, {0.0, 0.5, 2}};
  EXPECT_EQ(StabIntervals(at_the_cut).count, 2);
  EXPECT_NEAR(std::remainder(StabIntervals(at_the_cut).angle, kTurn), 0.0, 1e-12);
  const std::vector<AngleInterval> point = {{1.0, 1.0, 1}, {0.5, 1.5, 2}};
  EXPECT_EQ(StabIntervals(point).count, 2);
  EXPECT_NEAR(StabIntervals(point).angle, 1.0, 1e-12);
}

TEST(StabIntervals, FullTurnsCountEverywhere) {
  const std::vector<AngleInterval> intervals = {
      {0.0, kTurn, 1}, {1.0, 1.0 + kTurn, 2}, {-9.0, 9.0, 3}, {4.0, 4.5, 4}};
  const StabbingResult best = StabIntervals(intervals);
  EXPECT_EQ(best.count, 4);
  EXPECT_NEAR(best.angle, 4.25, 1e-12);
  const std::vector<AngleInterval> only_full = {{0.0, kTurn, 1}, {0.0, kTurn, 2}};
  EXPECT_EQ(StabIntervals(only_full).count, 2);
}

TEST(StabIntervals, AnIdCountsOnce) {
  const std::vector<AngleInterval> intervals = {{0.0, 1.0, 7}, {0.2, 0.8, 7}, {0.3, 0.6, 7},
                                                {2.0, 3.0, 1}, {2.5, 3.5, 2}, {2.1, 2.8, 1}};
  const StabbingResult best = StabIntervals(intervals);
  EXPECT_EQ(best.count, 2);
  EXPECT_EQ(CountAt(intervals, best.angle), 2);
}

TEST(StabIntervals, FindsTheSameInTheRunsThatHoldIt) {
  Random random(3);
  for (int round = 0; round < 300; ++round) {
    const auto intervals = RandomIntervals(random, 40, round % 3 == 0 ? 3.0 : 0.5, 25);
    const StabbingResult all = StabIntervals(intervals);
    RotationSectors sectors;
    for (const AngleInterval& interval : intervals) sectors.Add(ArcOf(interval));
    sectors.Count();
    for (const int bar : {0, all.count / 2, all.count - 1}) {
      const StabbingResult in_runs = StabIntervals(intervals, sectors.RunsAbove(bar));
      EXPECT_EQ(in_runs.count, all.count);
      EXPECT_EQ(in_runs.angle, all.angle);
    }
  }
}

}  // namespace
}  // namespace backsight
