#include "core/voxel_blocks.h"

#include <gtest/gtest.h>

#include <map>

#include "core/morton.h"
#include "core/random.h"

namespace backsight {
namespace {

TEST(Morton, ComesBack) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t bits = random.Index(std::uint64_t{1} << 48U);
    const std::array<std::uint16_t, 3> place{static_cast<std::uint16_t>(bits),
                                             static_cast<std::uint16_t>(bits >> 16U),
                                             static_cast<std::uint16_t>(bits >> 32U)};
    EXPECT_EQ(Morton::Place(Morton::Of(place)), place);
  }
  EXPECT_EQ(Morton::Of({0xFFFF, 0xFFFF, 0xFFFF}), (std::uint64_t{1} << 48U) - 1);
}

TEST(Morton, NumbersTheOctantsOfEveryLevelInTurn) {
  for (unsigned level = 0; level < 16; ++level) {
    const auto bit = static_cast<std::uint16_t>(1U << level);
    EXPECT_EQ(Morton::Of({bit, 0, 0}), std::uint64_t{1} << (3 * level));
    EXPECT_EQ(Morton::Of({0, bit, 0}), std::uint64_t{2} << (3 * level));
    EXPECT_EQ(Morton::Of({0, 0, bit}), std::uint64_t{4} << (3 * level));
  }
}

TEST(VoxelBlocks, HoldWhatAMapHolds) {
  Random random(2);
  VoxelBlocks<int> blocks;
  std::map<std::uint64_t, int> expected;
  for (int i = 0; i < 20000; ++i) {
    // Keys near one another and far apart.
    const std::uint64_t key = random.Index(3000) << (random.Index(3) * 13);
    const int more = static_cast<int>(random.Index(9)) + 1;
    blocks.At(key) += more;
    expected[key] += more;
  }
  ASSERT_EQ(blocks.size(), expected.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    EXPECT_EQ(blocks.blocks()[i], expected.at(blocks.keys()[i]));
  }
  for (const auto& [key, value] : expected) {
    ASSERT_NE(blocks.Find(key), nullptr);
    EXPECT_EQ(*blocks.Find(key), value);
  }
  EXPECT_EQ(blocks.Find(~std::uint64_t{0}), nullptr);
  EXPECT_GE(blocks.Bytes(), blocks.size() * (sizeof(int) + sizeof(std::uint64_t)));
}

}  // namespace
}  // namespace backsight
