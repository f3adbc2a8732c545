#include "graph/rotation_sectors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace backsight {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

double BeginOf(std::size_t sector) { return RotationSectors::AngleBefore(sector); }

TEST(TurnMeasure, IsTheDirectionInAnotherMeasure) {
  EXPECT_EQ(TurnOf(2.0, 0.0), 0.0);
  EXPECT_EQ(TurnOf(0.0, 2.0), 1.0);
  EXPECT_EQ(TurnOf(-2.0, 0.0), 2.0);
  EXPECT_EQ(TurnOf(0.0, -2.0), 3.0);
  double last = 0.0;
  for (double angle = 0.0; angle < kTurn; angle += 0.001) {
    const double turn = TurnOf(3.0 * std::cos(angle), 3.0 * std::sin(angle));
    EXPECT_GE(turn, last);
    EXPECT_LE(turn, kFullTurn);
    EXPECT_NEAR(AngleOf(turn), angle, 1e-14);
    last = turn;
  }
  EXPECT_EQ(AngleOf(kFullTurn), kTurn);
}

TEST(RotationSectors, BeginOneAfterTheOtherAllRound) {
  EXPECT_EQ(BeginOf(0), 0.0);
  EXPECT_EQ(BeginOf(RotationSectors::kCount), kTurn);
  for (std::size_t sector = 0; sector < RotationSectors::kCount; ++sector) {
    const RotationSectors::Run run{sector, sector + 1};
    EXPECT_EQ(run.begin_angle(), AngleOf(run.begin_turn()));
    EXPECT_EQ(run.end_angle(), AngleOf(run.end_turn()));
    const double width = run.end_angle() - run.begin_angle();
    EXPECT_GT(width, 0.6 * kTurn / RotationSectors::kCount);
    EXPECT_LT(width, 1.28 * kTurn / RotationSectors::kCount);
  }
}

TurnArc RandomArc(Random& random, bool about_the_cut) {
  // Every other trial about one direction, at the cut.
  const double begin = about_the_cut ? 0.03 * random.Normal() : random.Uniform(0.0, kFullTurn);
  const double width = random.Uniform(0.0, random.Index(8) == 0 ? 3.9 : 0.1);
  TurnArc arc{begin < 0.0 ? begin + kFullTurn : begin, 0.0, 0};
  arc.end = arc.begin + width;
  return random.Index(30) == 0 ? TurnArc{0.0, kFullTurn, 0} : arc;
}

TEST(RotationSectors, NoRotationLiesInMoreArcsThanItsSectorCounts) {
  Random random(3);
  RotationSectors sectors;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<TurnArc> arcs(1 + random.Index(60));
    sectors.Clear();
    for (TurnArc& arc : arcs) {
      arc = RandomArc(random, trial % 2 == 1);
      sectors.Add(arc);
    }
    const int fullest = sectors.Count();
    int most = 0;
    for (int step = 0; step < 5000; ++step) {
      const double turn = random.Uniform(0.0, kFullTurn);
      const auto sector = static_cast<std::size_t>(turn * RotationSectors::kCount / kFullTurn);
      const RotationSectors::Run its{sector, sector + 1};
      int inside = 0;
      for (const TurnArc& arc : arcs) {
        if (!Contains(arc, turn)) continue;
        ++inside;
        EXPECT_TRUE(its.Touches(arc));
      }
      most = std::max(most, inside);
      if (inside == 0) continue;
      const auto& runs = sectors.RunsAbove(inside - 1);
      EXPECT_TRUE(std::any_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
        return run.begin <= sector && sector < run.end;
      }));
    }
    EXPECT_LE(most, fullest);
    const double peak = sectors.PeakTurn();
    const auto& runs = sectors.RunsAbove(fullest - 1);
    EXPECT_TRUE(std::any_of(runs.begin(), runs.end(), [&](const RotationSectors::Run& run) {
      return run.begin_turn() <= peak && peak <= run.end_turn();
    }));
    EXPECT_TRUE(sectors.RunsAbove(fullest).empty());
  }
}

}  // namespace
}  // namespace backsight
