#include "pipeline/heartbeat.h"

#include <gtest/gtest.h>

#include <latch>

namespace backsight {
namespace {

TEST(Heartbeat, BeatsAgainAndAgain) {
  std::latch three(3);
  int beats = 0;
  const Heartbeat heartbeat(
      [&] {
        if (++beats <= 3) three.count_down();
      },
      std::chrono::milliseconds(1));
  three.wait();
}

TEST(Heartbeat, EndsWithoutWaitingForItsInterval) {
  int beats = 0;
  {
    const Heartbeat heartbeat([&] { ++beats; }, std::chrono::hours(1000));
  }
  EXPECT_EQ(beats, 0);
}

}  // namespace
}  // namespace backsight
