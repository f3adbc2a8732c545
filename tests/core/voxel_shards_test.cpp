#include "core/voxel_shards.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/random.h"

namespace backsight {
namespace {

/// Points along lines, as scanners see them, among others at random.
std::vector<Eigen::Vector3d> ScanPoints(std::size_t n) {
  Random random(5);
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 50 == 0) {
      at = {random.Uniform(-30, 30), random.Uniform(-30, 30), random.Uniform(-3, 9)};
    }
    at += Eigen::Vector3d(0.013, -0.008, 0.004);
    points.push_back(at);
  }
  return points;
}

bool SameBits(const PointCluster& a, const PointCluster& b) {
  return a.count == b.count && std::memcmp(a.mean.data(), b.mean.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.scatter.data(), b.scatter.data(), 9 * sizeof(double)) == 0;
}

TEST(VoxelShards, HaveTheBitsOfOneClustererForAnyThreadsAndBatches) {
  const VoxelLattice lattice{.edge_m = 0.1, .origin = {3.0, -2.0, 100.0}};
  const auto points = ScanPoints(100000);
  VoxelClusterer clusterer(lattice);
  for (const auto& point : points) clusterer.Add(point);
  const VoxelLeaves expected = clusterer.Finish();
  EXPECT_GT(expected.size(), 5000U);
  for (const int threads : {1, 2, 7}) {
    const ExecutionContext context(threads);
    for (const std::size_t most : {std::size_t{1000}, std::size_t{65536}, points.size()}) {
      VoxelShards shards(lattice);
      VoxelShards::Batch batch;
      for (std::size_t begin = 0; begin < points.size(); begin += most) {
        batch.Clear();
        const std::size_t end = std::min(points.size(), begin + most);
        for (std::size_t i = begin; i < end; ++i) batch.Add(lattice, points[i]);
        EXPECT_EQ(batch.size(), end - begin);
        batch.Sort();
        shards.Add(batch, context);
      }
      const VoxelLeaves leaves = shards.Finish();
      ASSERT_EQ(leaves.size(), expected.size());
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        ASSERT_EQ(leaves.Key(i), expected.Key(i));
        ASSERT_TRUE(SameBits(leaves.Cluster(i), expected.Cluster(i)))
            << threads << " threads, leaf " << i;
      }
    }
  }
}

TEST(VoxelShards, AreEmptyWithoutPoints) {
  VoxelShards shards({.edge_m = 0.1});
  VoxelShards::Batch batch;
  batch.Sort();
  shards.Add(batch, ExecutionContext(2));
  EXPECT_TRUE(shards.Finish().empty());
}

}  // namespace
}  // namespace backsight
