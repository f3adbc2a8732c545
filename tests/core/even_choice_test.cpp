#include "core/even_choice.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

TEST(EvenChoice, TakesNoMoreThanAskedForAndSpreadsThem) {
  for (const std::size_t size : {1U, 2U, 19U, 39'999U}) {
    for (const std::size_t most : {1U, 7U, 20'000U}) {
      const EvenChoice chosen(size, most);
      ASSERT_EQ(chosen.count(), std::min(size, most));
      const std::size_t step = size / chosen.count();
      EXPECT_EQ(chosen[0], 0U);
      for (std::size_t i = 0; i < chosen.count(); ++i) {
        const std::size_t next = i + 1 < chosen.count() ? chosen[i + 1] : size;
        EXPECT_GE(next - chosen[i], step);
        EXPECT_LE(next - chosen[i], step + 1);
      }
    }
  }
}

TEST(EvenChoice, HoldsNothingOfNothing) {
  EXPECT_EQ(EvenChoice(0, 5).count(), 0U);
  EXPECT_EQ(EvenChoice(5, 0).count(), 0U);
}

}  // namespace
}  // namespace backsight
