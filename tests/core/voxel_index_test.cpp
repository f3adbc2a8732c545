#include "core/voxel_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/neighbors.h"
#include "core/random.h"

namespace backsight {
namespace {

struct Cloud {
  VoxelPoints voxels{{.edge_m = 0.1, .origin = {0.03, -0.02, 0.01}}};
  std::vector<Eigen::Vector3d> points;  // as they are given back
};

/// Points on a few planes and at random, so that there are full and empty bricks.
Cloud MakeCloud(std::uint64_t seed, int points) {
  Random random(seed);
  Cloud cloud;
  std::map<std::uint64_t, Eigen::Vector3d> voxels;
  for (int i = 0; i < points; ++i) {
    Eigen::Vector3d p(random.Uniform(-2.0, 2.0), random.Uniform(-2.0, 2.0),
                      random.Uniform(-1.0, 1.0));
    if (i % 3 == 0) p.z() = 0.01 * random.Normal();
    if (i % 3 == 1) p.x() = 1.0 + 0.01 * random.Normal();
    voxels[cloud.voxels.lattice().Key(p)] = p;
  }
  for (const auto& [key, point] : voxels) cloud.voxels.Add(key, point);
  cloud.points.assign(cloud.voxels.begin(), cloud.voxels.end());
  return cloud;
}

TEST(VoxelIndex, FindsEveryVoxelAndNothingElse) {
  const Cloud cloud = MakeCloud(1, 4000);
  const VoxelIndex index(cloud.voxels);
  for (std::size_t i = 0; i < cloud.voxels.size(); ++i) {
    EXPECT_EQ(index.Find(VoxelLattice::Unpack(cloud.voxels.keys()[i])), i);
  }
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3i cell(static_cast<int>(random.Index(60)) - 30,
                               static_cast<int>(random.Index(60)) - 30,
                               static_cast<int>(random.Index(40)) - 20);
    const bool is_there = std::binary_search(cloud.voxels.keys().begin(), cloud.voxels.keys().end(),
                                             VoxelLattice::Pack(cell));
    EXPECT_EQ(index.Find(cell).has_value(), is_there);
  }
}

TEST(VoxelIndex, VisitsTheCellAndItsFaceNeighbours) {
  const Cloud cloud = MakeCloud(3, 4000);
  const VoxelIndex index(cloud.voxels);
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d query(random.Uniform(-2.3, 2.3), random.Uniform(-2.3, 2.3),
                                random.Uniform(-1.3, 1.3));
    const Eigen::Vector3i cell = cloud.voxels.lattice().Cell(query);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t k = 0; k < cloud.voxels.size(); ++k) {
      const Eigen::Vector3i step = VoxelLattice::Unpack(cloud.voxels.keys()[k]) - cell;
      if (step.cwiseAbs().sum() <= 1) expected.push_back(k);
    }
    std::vector<std::uint32_t> visited;
    index.VisitAround(query, [&](std::uint32_t voxel) { visited.push_back(voxel); });
    std::sort(visited.begin(), visited.end());
    ASSERT_EQ(visited, expected);
  }
}

TEST(VoxelIndex, NearestEqualsTheSearchTree) {
  for (std::uint64_t seed = 10; seed < 14; ++seed) {
    const Cloud cloud = MakeCloud(seed, 500 * static_cast<int>(seed - 9));
    const VoxelIndex index(cloud.voxels);
    const NeighborSearch tree(cloud.points);
    Random random(seed);
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3d query(random.Uniform(-2.5, 2.5), random.Uniform(-2.5, 2.5),
                                  random.Uniform(-1.5, 1.5));
      const double radius = random.Uniform(0.02, 0.45);
      const auto expected = tree.Nearest(query, 2);
      const auto nearest = index.Nearest(cloud.voxels, query, radius);
      ASSERT_EQ(nearest.has_value(), expected[0].distance_m <= radius);
      if (!nearest) continue;
      EXPECT_EQ(nearest->voxel, expected[0].index);
      EXPECT_NEAR(std::sqrt(nearest->squared_m2), expected[0].distance_m, 1e-14);
      const double others_m = std::sqrt(nearest->others_squared_m2);
      constexpr double kRounding = 1e-9;
      EXPECT_LE(others_m, std::min(expected[1].distance_m, radius) + kRounding);
      EXPECT_GE(
          others_m,
          std::min({expected[1].distance_m, radius, cloud.voxels.lattice().edge_m}) - kRounding);
    }
  }
}

TEST(VoxelIndex, WithinEqualsTheSearchTree) {
  const Cloud cloud = MakeCloud(20, 4000);
  const VoxelIndex index(cloud.voxels);
  const NeighborSearch tree(cloud.points);
  Random random(21);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d query(random.Uniform(-2.5, 2.5), random.Uniform(-2.5, 2.5),
                                random.Uniform(-1.5, 1.5));
    const double radius = i % 10 == 0 ? random.Uniform(0.5, 3.0) : random.Uniform(0.0, 0.4);
    std::vector<NeighborSearch::Neighbor> found;
    index.VisitWithin(cloud.voxels, query, radius, [&](std::uint32_t voxel, double squared_m2) {
      found.push_back({voxel, std::sqrt(squared_m2)});
    });
    auto expected = tree.Within(query, radius);
    const auto by_index = [](const auto& a, const auto& b) { return a.index < b.index; };
    std::sort(found.begin(), found.end(), by_index);
    std::sort(expected.begin(), expected.end(), by_index);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].index, expected[k].index);
      EXPECT_NEAR(found[k].distance_m, expected[k].distance_m, 1e-14);
    }
  }
}

TEST(VoxelIndex, EqualDistancesGoToTheLowerVoxel) {
  const VoxelLattice lattice{.edge_m = 1.0};
  // The middles of places that mirror each other.
  const std::array<Eigen::Vector3d, 2> points{Eigen::Vector3d(16384.5 / 65536.0, 0.5, 0.5),
                                              Eigen::Vector3d(2.0 - 16384.5 / 65536.0, 0.5, 0.5)};
  for (const std::size_t first : {0U, 1U}) {
    VoxelPoints voxels(lattice);
    for (const std::size_t i : {first, 1 - first}) voxels.Add(lattice.Key(points[i]), points[i]);
    EXPECT_EQ(voxels[0], points[first] + Eigen::Vector3d(0.0, 0.5, 0.5) / 65536.0);
    const Eigen::Vector3d middle(1.0, 0.5, 0.5);
    EXPECT_EQ(VoxelIndex(voxels).Nearest(voxels, middle, 2.0)->voxel, 0U);
  }
}

TEST(VoxelIndex, MayBeEmptyAndIsAskedAnywhere) {
  const VoxelPoints none({.edge_m = 0.1});
  const VoxelIndex empty(none);
  EXPECT_FALSE(empty.Find({0, 0, 0}).has_value());
  EXPECT_FALSE(empty.Nearest(none, Eigen::Vector3d::Zero(), 1.0).has_value());
  EXPECT_FALSE(empty.Nearest(none, Eigen::Vector3d::Constant(1e9), 1.0).has_value());
  empty.VisitWithin(none, Eigen::Vector3d::Zero(), 1.0, [](std::uint32_t, double) { FAIL(); });
  empty.VisitAround(Eigen::Vector3d::Constant(-1e9), [](std::uint32_t) { FAIL(); });
}

}  // namespace
}  // namespace backsight
