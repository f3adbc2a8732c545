#include "core/key_slot.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/voxel_grid.h"

namespace backsight {
namespace {

/// Places that linear probing looks at to insert a key, on average, in a table twice as large as
/// its keys; 1.5 for keys spread at random.
double MeanSearch(const std::vector<std::uint64_t>& keys) {
  std::size_t places = 1;
  while (places < 2 * keys.size()) places *= 2;
  std::vector<char> taken(places, 0);
  std::size_t looked_at = 0;
  for (const std::uint64_t key : keys) {
    std::size_t slot = KeySlot(key, places - 1);
    for (++looked_at; taken[slot] != 0; ++looked_at) slot = (slot + 1) & (places - 1);
    taken[slot] = 1;
  }
  return static_cast<double>(looked_at) / static_cast<double>(keys.size());
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
  constexpr double kNearlyRandom = 3.0;
  for (const int n : {100, 500}) {
    EXPECT_LT(MeanSearch(Block(n, 1, 1)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(1, n, 1)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(1, 1, n)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(n, 3, 3)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(n, 90, 1)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(n, 1, 90)), kNearlyRandom) << n;
    EXPECT_LT(MeanSearch(Block(1, n, 90)), kNearlyRandom) << n;
  }
  EXPECT_LT(MeanSearch(Block(1, 184, 176)), kNearlyRandom);
  EXPECT_LT(MeanSearch(Block(20, 20, 20)), kNearlyRandom);
}

TEST(KeySlot, StaysWithinTablesOfAnySize) {
  for (const std::size_t mask : {0U, 1U, 3U, 1023U}) {
    for (const std::uint64_t key : Block(7, 7, 7)) EXPECT_LE(KeySlot(key, mask), mask);
  }
}

}  // namespace
}  // namespace backsight
