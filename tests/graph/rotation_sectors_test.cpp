#include "graph/rotation_sectors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(RotationSectors, BeginOneAfterTheOtherAllRound) {
  EXPECT_EQ(RotationSectors::BeginOf(0), 0.0);
  EXPECT_EQ(RotationSectors::BeginOf(RotationSectors::kCount), kTurn);
  for (std::size_t sector = 0; sector < RotationSectors::kCount; ++sector) {
    const double width = RotationSectors::BeginOf(sector + 1) - RotationSectors::BeginOf(sector);
    EXPECT_GT(width, 0.6 * kTurn / RotationSectors::kCount);
    EXPECT_LT(width, 1.28 * kTurn / RotationSectors::kCount);
  }
}

TEST(RotationSectors, NoAngleLiesInMoreIntervalsThanItsSectorCounts) {
  struct Interval {
    double center, half;
  };
  Random random(3);
  RotationSectors sectors;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<Interval> intervals(1 + random.Index(60));
    std::vector<RotationSectors::Range> ranges;
    sectors.Clear();
    for (Interval& interval : intervals) {
      // Every other trial about one direction, at times at the cut.
      interval.center = trial % 2 == 0 ? random.Uniform(0.0, kTurn) : 0.05 * random.Normal();
      interval.half = random.Uniform(0.0, random.Index(8) == 0 ? 2.0 : 0.1);
      ranges.push_back(RotationSectors::RangeOf(3.0 * std::cos(interval.center),
                                                3.0 * std::sin(interval.center),
                                                std::cos(interval.half)));
      sectors.Add(ranges.back());
    }
    sectors.Count();
    int most = 0;
    for (int step = 0; step < 5000; ++step) {
      const double angle = random.Uniform(0.0, kTurn);
      std::size_t sector = 0;
      while (RotationSectors::BeginOf(sector + 1) < angle) ++sector;
      int inside = 0;
      for (std::size_t i = 0; i < intervals.size(); ++i) {
        const double off = std::abs(std::remainder(angle - intervals[i].center, kTurn));
        if (off > intervals[i].half) continue;
        ++inside;
        EXPECT_TRUE(ranges[i].Touches(sector, sector + 1));
      }
      most = std::max(most, inside);
      if (inside == 0) continue;
      const auto& runs = sectors.RunsAbove(inside - 1);
      EXPECT_TRUE(std::any_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
        return run.begin <= sector && sector < run.end;
      }));
    }
    const double peak = sectors.PeakAngle();
    const auto& runs = sectors.RunsAbove(most - 1);
    EXPECT_TRUE(std::any_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
      return RotationSectors::BeginOf(run.begin) <= peak &&
             peak <= RotationSectors::BeginOf(run.end);
    }));
  }
}

}  // namespace
}  // namespace backsight
