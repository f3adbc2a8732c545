#include "stages/map_grid.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <vector>

#include "core/random.h"

namespace backsight {
namespace {

std::uint64_t Voxel(const octomap::OcTreeKey& key) { return Morton::Of({key[0], key[1], key[2]}); }

octomap::point3d Octomap(const Eigen::Vector3f& p) { return {p.x(), p.y(), p.z()}; }

Eigen::Vector3f RandomPoint(Random* random, double reach_m) {
  return Eigen::Vector3d(random->Uniform(-reach_m, reach_m), random->Uniform(-reach_m, reach_m),
                         random->Uniform(-reach_m, reach_m))
      .cast<float>();
}

std::vector<std::uint64_t> Crossed(const MapGrid& grid, const Eigen::Vector3f& from,
                                   const Eigen::Vector3f& to) {
  std::vector<std::uint64_t> voxels;
  grid.VisitBeam(from, to, [&](std::uint64_t voxel) { voxels.push_back(voxel); });
  return voxels;
}

std::vector<std::uint64_t> CrossedInOctomap(const octomap::OcTree& map, const Eigen::Vector3f& from,
                                            const Eigen::Vector3f& to) {
  octomap::KeyRay ray;
  std::vector<std::uint64_t> voxels;
  if (!map.computeRayKeys(Octomap(from), Octomap(to), ray)) return voxels;
  for (const octomap::OcTreeKey& key : ray) voxels.push_back(Voxel(key));
  return voxels;
}

TEST(MapGrid, NumbersVoxelsAsOctomapDoes) {
  Random random(1);
  for (const double resolution_m : {0.2, 0.07}) {
    const octomap::OcTree map(resolution_m);
    const MapGrid grid(resolution_m);
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3f point = RandomPoint(&random, 3000.0);
      octomap::OcTreeKey key(0, 0, 0);
      const auto voxel = grid.VoxelAt(point);
      ASSERT_EQ(map.coordToKeyChecked(Octomap(point), key), voxel.has_value());
      if (!voxel) continue;
      EXPECT_EQ(*voxel, Voxel(key));
      EXPECT_EQ(Octomap(grid.CenterOf(*voxel)), map.keyToCoord(key));
    }
  }
}

TEST(MapGrid, BeamsCrossTheVoxelsThatOctomapFinds) {
  Random random(2);
  const octomap::OcTree map(0.2);
  const MapGrid grid(0.2);
  std::size_t crossed = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3f from = RandomPoint(&random, 2.0);
    const Eigen::Vector3f to = RandomPoint(&random, i % 2 == 0 ? 2.0 : 60.0);
    const auto expected = CrossedInOctomap(map, from, to);
    ASSERT_EQ(Crossed(grid, from, to), expected);
    crossed += expected.size();
  }
  EXPECT_GT(crossed, 100000U);
}

TEST(MapGrid, BeamsAlongAxesAndBordersCrossTheVoxelsThatOctomapFinds) {
  const octomap::OcTree map(0.5);
  const MapGrid grid(0.5);
  for (const float x : {-3.0F, -0.25F, 0.0F, 3.0F}) {
    for (const float y : {-3.0F, 0.0F, 0.25F, 3.0F}) {
      for (const float z : {-3.0F, 0.0F, 3.0F}) {
        for (const float start : {0.0F, 0.25F, 0.1F}) {
          const Eigen::Vector3f from(start, start, start);
          EXPECT_EQ(Crossed(grid, from, {x, y, z}), CrossedInOctomap(map, from, {x, y, z}));
        }
      }
    }
  }
}

TEST(MapGrid, BeamsFromOutsideCrossNothing) {
  const MapGrid grid(0.2);
  EXPECT_TRUE(Crossed(grid, {7000.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 0.0F}).empty());
  EXPECT_TRUE(Crossed(grid, {0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, -7000.0F}).empty());
  EXPECT_FALSE(grid.VoxelAt({0.0F, NAN, 0.0F}));
}

}  // namespace
}  // namespace backsight
