#include "core/voxel_leaves.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "core/error.h"
#include "core/random.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

TEST(VoxelLeaves, PartsMergeIntoAllByKey) {
  Random random(6);
  const VoxelLattice lattice{.edge_m = 0.1};
  std::map<std::uint64_t, std::pair<std::size_t, PointCluster>> all;  // with its part
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d mean(random.Uniform(-9, 9), random.Uniform(-9, 9), random.Uniform(-3, 3));
    const Eigen::Matrix3d scatter = Eigen::Vector3d(1.0 + i, 2.0 + i, 0.5).asDiagonal();
    all.try_emplace(lattice.Key(mean), random.Index(7), PointCluster{4.0 + i, mean, scatter});
  }
  std::vector<VoxelLeaves> parts(8, VoxelLeaves(lattice));  // the last one stays empty
  VoxelLeaves expected(lattice);
  for (const auto& [key, voxel] : all) {
    parts[voxel.first].Add(key, voxel.second);
    expected.Add(key, voxel.second);
  }
  const VoxelLeaves leaves = VoxelLeaves::Merge(std::move(parts));
  ASSERT_EQ(leaves.size(), all.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    EXPECT_EQ(leaves.Key(i), expected.Key(i));
    EXPECT_EQ(leaves.Mean(i), expected.Mean(i));
    EXPECT_EQ(leaves.Count(i), expected.Count(i));
    EXPECT_EQ(leaves.Cluster(i).scatter, expected.Cluster(i).scatter);
  }
}

TEST(VoxelLeaves, OfTwoLatticesAreNotMerged) {
  std::vector<VoxelLeaves> parts{VoxelLeaves({.edge_m = 0.1}), VoxelLeaves({.edge_m = 0.2})};
  EXPECT_THROW(VoxelLeaves::Merge(std::move(parts)), InternalError);
}

TEST(VoxelLeaves, OfNoPartsAreNone) {
  EXPECT_TRUE(VoxelLeaves::Merge({}).empty());
  EXPECT_TRUE(VoxelLeaves::Merge(std::vector<VoxelLeaves>(3)).empty());
}

}  // namespace
}  // namespace backsight
