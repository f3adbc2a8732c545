#include "core/key_slot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// Most places that linear probing looks at to insert a key, in a table twice as large as its keys.
std::size_t LongestSearch(const std::vector<std::uint64_t>& keys) {
  std::size_t places = 1;
  while (places < 2 * keys.size()) places *= 2;
  std::vector<char> taken(places, 0);
  std::size_t longest = 0;
  for (const std::uint64_t key : keys) {
    std::size_t slot = KeySlot(key, places - 1);
    std::size_t looked_at = 1;
    for (; taken[slot] != 0; ++looked_at) slot = (slot + 1) & (places - 1);
    taken[slot] = 1;
    longest = std::max(longest, looked_at);
  }
  return longest;
}

/// A block of voxels, as many along each axis as given.
std::vector<std::uint64_t> Block(int x, int y, int z) {
  const VoxelLattice lattice{.edge_m = 1.0};
  std::vector<std::uint64_t> keys;
  for (int i = 0; i < x; ++i) {
    for (int j = 0; j < y; ++j) {
      for (int k = 0; k < z; ++k) keys.push_back(lattice.Key(Eigen::Vector3d(i, j, k)));
    }
  }
  return keys;
}

TEST(KeySlot, SpreadsLinesWallsAndBlocksAlongAnyAxis) {
  for (const int n : {20, 100, 500}) {
    EXPECT_LT(LongestSearch(Block(n, 1, 1)), 20U) << n;
    EXPECT_LT(LongestSearch(Block(1, n, 1)), 20U) << n;
    EXPECT_LT(LongestSearch(Block(1, 1, n)), 20U) << n;
    EXPECT_LT(LongestSearch(Block(n, 3, 3)), 40U) << n;
    EXPECT_LT(LongestSearch(Block(n, 1, 30)), 40U) << n;
  }
  EXPECT_LT(LongestSearch(Block(20, 20, 20)), 40U);
}

TEST(KeySlot, StaysWithinTablesOfAnySize) {
  for (const std::size_t mask : {0U, 1U, 3U, 1023U}) {
    for (const std::uint64_t key : Block(7, 7, 7)) EXPECT_LE(KeySlot(key, mask), mask);
  }
}

}  // namespace
}  // namespace backsight
