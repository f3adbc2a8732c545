#include "io/octomap_file.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "core/morton.h"
#include "core/random.h"

namespace backsight {
namespace {

/// Values of voxels, block by block.
using Blocks = std::map<std::uint64_t, OctomapBlock>;

std::string OwnBytes(const Blocks& blocks, double resolution_m) {
  std::vector<std::uint64_t> keys;
  for (const auto& [key, values] : blocks) keys.push_back(key);
  return OctomapBytes(resolution_m, keys,
                      [&](std::size_t i, OctomapBlock& values) { values = blocks.at(keys[i]); });
}

/// Voxel by voxel into OctoMap's own tree.
std::string OctomapsBytes(const Blocks& blocks, double resolution_m) {
  octomap::OcTree map(resolution_m);
  for (const auto& [key, values] : blocks) {
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (std::isnan(values[v])) continue;
      const auto place = Morton::Place(key << 9U | v);
      map.setNodeValue(octomap::OcTreeKey(place[0], place[1], place[2]), values[v], true);
    }
  }
  map.updateInnerOccupancy();
  map.prune();
  std::ostringstream bytes;
  map.write(bytes);
  return std::move(bytes).str();
}

/// Voxels that agree in octants of several sizes, as rooms do, with some unknown.
OctomapBlock RandomBlock(Random* random) {
  constexpr float kValues[] = {-2.0F, -0.4F, 0.85F, 3.5F, NAN};
  OctomapBlock values;
  const auto run = std::size_t{1} << (3 * random->Index(4));
  for (std::size_t begin = 0; begin < values.size(); begin += run) {
    std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(begin), run,
                kValues[random->Index(std::size(kValues))]);
  }
  values[random->Index(values.size())] = 0.85F;  // none is quite unknown
  return values;
}

TEST(OctomapFile, HasTheBytesOfOctomap) {
  Random random(3);
  for (const double resolution_m : {0.2, 0.05, 1.0 / 3.0}) {
    Blocks blocks;
    for (int i = 0; i < 300; ++i) {
      blocks[random.Index(std::uint64_t{1} << (i < 100 ? 6U : 39U))] = RandomBlock(&random);
    }
    EXPECT_EQ(OwnBytes(blocks, resolution_m), OctomapsBytes(blocks, resolution_m));
  }
}

TEST(OctomapFile, EqualBlocksBecomeOneLeafHigherUp) {
  OctomapBlock free;
  free.fill(-0.4F);
  Blocks blocks;
  for (std::uint64_t key = 0; key < 8 * 8; ++key) blocks[(std::uint64_t{1} << 36U) + key] = free;
  const std::string bytes = OwnBytes(blocks, 0.1);
  EXPECT_EQ(bytes, OctomapsBytes(blocks, 0.1));
  EXPECT_NE(bytes.find("size 12\n"), std::string::npos);  // the way down from the root
  blocks[7][9] = 0.85F;
  EXPECT_EQ(OwnBytes(blocks, 0.1), OctomapsBytes(blocks, 0.1));
}

TEST(OctomapFile, OfNothingIsReadAsAnEmptyMap) {
  std::istringstream stream(OwnBytes({}, 0.1));
  const std::unique_ptr<octomap::AbstractOcTree> map(octomap::AbstractOcTree::read(stream));
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(map->size(), 0U);
  EXPECT_EQ(OwnBytes({}, 0.1), OctomapsBytes({}, 0.1));
}

}  // namespace
}  // namespace backsight
