#include "pipeline/progress_text.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

TEST(ProgressText, StatesDurationsInUnitsThatReadWell) {
  EXPECT_EQ(DurationText(0.0), "0.0 s");
  EXPECT_EQ(DurationText(9.94), "9.9 s");
  EXPECT_EQ(DurationText(9.96), "10 s");
  EXPECT_EQ(DurationText(59.4), "59 s");
  EXPECT_EQ(DurationText(59.6), "1 min 00 s");
  EXPECT_EQ(DurationText(303.0), "5 min 03 s");
  EXPECT_EQ(DurationText(3599.7), "1 h 00 min");
  EXPECT_EQ(DurationText(7510.0), "2 h 05 min");
}

TEST(ProgressText, StatesRatesPerSecondOrPerMinute) {
  EXPECT_EQ(RateText(1234.0), "1234/s");
  EXPECT_EQ(RateText(12.4), "12/s");
  EXPECT_EQ(RateText(3.24), "3.2/s");
  EXPECT_EQ(RateText(0.5), "30/min");
  EXPECT_EQ(RateText(0.05), "3.0/min");
  EXPECT_EQ(RateText(0.001), "0.06/min");
}

TEST(ProgressText, LineStatesCountRateElapsedAndRemaining) {
  EXPECT_EQ(ProgressText("stations", 3, 12, 90.0),
            "stations           3 of 12     2.0/min  1 min 30 s, about 4 min 30 s left");
  EXPECT_EQ(ProgressText("stations", 12, 12, 6.0), "stations          12 of 12       2.0/s  6.0 s");
}

TEST(ProgressText, RateIsOfWhatWasDoneSinceTheStageBegan) {
  EXPECT_EQ(ProgressText("pairs", 8, 12, 3.0, /*before=*/5),
            "pairs              8 of 12       1.0/s  3.0 s, about 4.0 s left");
}

TEST(ProgressText, LineClaimsNothingBeforeTheFirstUnit) {
  EXPECT_EQ(ProgressText("stations", 0, 12, 40.0), "stations           0 of 12              40 s");
  EXPECT_EQ(ProgressText("stations", 5, 12, 0.0), "stations           5 of 12              0.0 s");
}

TEST(ProgressText, StageOfOneUnitHasNoCount) {
  EXPECT_EQ(ProgressText("network", 0, 1, 40.0), StageText("network", 40.0));
  EXPECT_EQ(StageText("network", 40.0), "network                                40 s");
}

}  // namespace
}  // namespace backsight
