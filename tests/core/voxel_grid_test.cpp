#include "core/voxel_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/random.h"

namespace backsight {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(std::uint64_t seed, std::size_t n,
                                          const Eigen::Vector3d& center) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points(n);
  for (auto& p : points) {
    p = center +
        Eigen::Vector3d(random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(-2, 2));
  }
  return points;
}

VoxelLeaves Cluster(const std::vector<Eigen::Vector3d>& points, const VoxelLattice& l) {
  VoxelClusterer clusterer(l);
  for (const auto& p : points) clusterer.Add(p);
  return clusterer.Finish();
}

constexpr double kPlace = 0x1p-17;  // edges: what voxels' means are rounded by
constexpr double kSpread = 1e-4;    // the same of their scatter

TEST(VoxelGrid, EqualsBruteForce) {
  const VoxelLattice lattice{.edge_m = 0.3};
  const auto points = RandomPoints(1, 5000, {0.1, -0.2, 3.0});
  std::map<std::array<int, 3>, std::vector<Eigen::Vector3d>> expected;
  for (const auto& p : points) {
    expected[{static_cast<int>(std::floor(p.x() / 0.3)), static_cast<int>(std::floor(p.y() / 0.3)),
              static_cast<int>(std::floor(p.z() / 0.3))}]
        .push_back(p);
  }
  VoxelClusterer clusterer(lattice);
  for (const auto& p : points) clusterer.Add(p);
  const VoxelLeaves leaves = clusterer.Finish();
  ASSERT_EQ(leaves.size(), expected.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const PointCluster found = leaves.Cluster(i);
    const Eigen::Vector3i cell = VoxelLattice::Unpack(leaves.Key(i));
    const auto& members = expected.at({cell.x(), cell.y(), cell.z()});
    ASSERT_EQ(found.count, static_cast<double>(members.size()));
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : members) mean += p / static_cast<double>(members.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& p : members) scatter += (p - mean) * (p - mean).transpose();
    EXPECT_LT((found.mean - mean).lpNorm<Eigen::Infinity>(), kPlace * lattice.edge_m + 1e-12);
    EXPECT_LE((found.scatter - scatter).norm(), kSpread * scatter.norm() + 1e-15);
  }
}

TEST(VoxelGrid, DoesNotDependOnPointOrderBeyondRounding) {
  auto points = RandomPoints(2, 3000, Eigen::Vector3d::Zero());
  const auto forward = Cluster(points, {.edge_m = 0.25});
  std::reverse(points.begin(), points.end());
  const auto backward = Cluster(points, {.edge_m = 0.25});
  ASSERT_EQ(forward.size(), backward.size());
  for (std::size_t i = 0; i < forward.size(); ++i) {
    EXPECT_EQ(forward.Key(i), backward.Key(i));
    EXPECT_LT((forward.Mean(i) - backward.Mean(i)).norm(), kPlace * 0.25);
  }
}

TEST(VoxelGrid, ScatterSurvivesCoordinatesOfMillions) {
  const Eigen::Vector3d far(691000.0, 5335000.0, 500.0);
  const auto near_points = RandomPoints(3, 2000, Eigen::Vector3d::Zero());
  auto far_points = near_points;
  for (auto& p : far_points) p += far;
  const auto near_leaves = Cluster(near_points, {.edge_m = 0.5});
  const auto far_leaves = Cluster(far_points, {.edge_m = 0.5, .origin = far});
  ASSERT_EQ(near_leaves.size(), far_leaves.size());
  for (std::size_t i = 0; i < near_leaves.size(); ++i) {
    EXPECT_LT((near_leaves.Cluster(i).scatter - far_leaves.Cluster(i).scatter).norm(), 1e-6);
  }
}

TEST(VoxelGrid, ClustersAreAdditive) {
  const auto points = RandomPoints(4, 4000, {5.0, 5.0, 5.0});
  PointCluster whole;
  for (const auto& p : points) whole += {1.0, p, Eigen::Matrix3d::Zero()};
  PointCluster sum;
  const VoxelLeaves parts = Cluster(points, {.edge_m = 0.2});
  for (std::size_t i = 0; i < parts.size(); ++i) sum += parts.Cluster(i);
  EXPECT_EQ(sum.count, whole.count);
  EXPECT_LT((sum.mean - whole.mean).norm(), kPlace * 0.2);
  EXPECT_LT((sum.scatter - whole.scatter).norm(), 1e-6 * whole.scatter.norm());
}

TEST(VoxelGrid, KeysRoundTripAtTheLimits) {
  for (const int i : {-1048570, -1, 0, 1, 1048570}) {
    const Eigen::Vector3i cell(i, -i, i / 2);
    EXPECT_EQ(VoxelLattice::Unpack(VoxelLattice::Pack(cell)), cell);
  }
  const VoxelLattice lattice{.edge_m = 0.1};
  EXPECT_TRUE(lattice.Contains({1e5, -1e5, 0}));
  EXPECT_FALSE(lattice.Contains({1.1e5, 0, 0}));
}

}  // namespace
}  // namespace backsight
