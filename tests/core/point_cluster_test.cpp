#include "core/point_cluster.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/random.h"

namespace backsight {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points RandomPoints(Random& random, std::size_t n, const Eigen::Vector3d& center) {
  Points points(n);
  for (auto& p : points) {
    p = center + Eigen::Vector3d(random.Normal(), 2.0 * random.Normal(), 0.1 * random.Normal());
  }
  return points;
}

/// Straight from the definition, in two passes.
PointCluster TwoPass(const Points& points) {
  PointCluster cluster;
  cluster.count = static_cast<double>(points.size());
  for (const auto& p : points) cluster.mean += p / cluster.count;
  for (const auto& p : points) {
    cluster.scatter += (p - cluster.mean) * (p - cluster.mean).transpose();
  }
  return cluster;
}

void ExpectNear(const PointCluster& a, const PointCluster& b, double tolerance) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_LT((a.mean - b.mean).norm(), tolerance);
  EXPECT_LT((a.scatter - b.scatter).norm(), tolerance * (1.0 + b.scatter.norm()));
}

TEST(PointCluster, SumEqualsTheClusterOfAllPoints) {
  Random random(1);
  Points all;
  PointCluster sum;
  for (int part = 0; part < 20; ++part) {
    const Points points = RandomPoints(random, 1 + random.Index(30),
                                       {random.Normal(), random.Normal(), random.Normal()});
    all.insert(all.end(), points.begin(), points.end());
    sum += TwoPass(points);
  }
  ExpectNear(sum, TwoPass(all), 1e-12);
  EXPECT_LT((sum.Covariance() - TwoPass(all).scatter / static_cast<double>(all.size())).norm(),
            1e-12);
}

TEST(PointCluster, SinglePointsMakeAnyCluster) {
  Random random(2);
  const Points points = RandomPoints(random, 100, {1.0, 2.0, 3.0});
  PointCluster sum;
  for (const auto& p : points) sum += PointCluster{1.0, p, Eigen::Matrix3d::Zero()};
  ExpectNear(sum, TwoPass(points), 1e-12);
}

TEST(PointCluster, AddingNothingChangesNothing) {
  Random random(3);
  const PointCluster cluster = TwoPass(RandomPoints(random, 10, {5.0, 6.0, 7.0}));
  ExpectNear(cluster + PointCluster{}, cluster, 1e-15);
  ExpectNear(PointCluster{} + cluster, cluster, 1e-15);
  const PointCluster nothing = PointCluster{} + PointCluster{};
  EXPECT_EQ(nothing.count, 0.0);
  EXPECT_TRUE(nothing.mean.allFinite());
}

TEST(PointCluster, SumDoesNotDependOnOrderBeyondRounding) {
  Random random(4);
  const PointCluster a = TwoPass(RandomPoints(random, 10, {0.0, 0.0, 0.0}));
  const PointCluster b = TwoPass(RandomPoints(random, 1000, {3.0, -2.0, 1.0}));
  const PointCluster c = TwoPass(RandomPoints(random, 3, {-30.0, 20.0, 5.0}));
  ExpectNear((a + b) + c, a + (b + c), 1e-11);
  ExpectNear(a + b, b + a, 1e-12);
}

TEST(PointCluster, KeepsItsScatterFarFromTheOrigin) {
  Random random(5);
  const Eigen::Vector3d far(691000.0, 5335000.0, 500.0);
  const Points near_points = RandomPoints(random, 200, Eigen::Vector3d::Zero());
  PointCluster near_sum;
  PointCluster far_sum;
  for (const auto& p : near_points) {
    near_sum += PointCluster{1.0, p, Eigen::Matrix3d::Zero()};
    far_sum += PointCluster{1.0, p + far, Eigen::Matrix3d::Zero()};
  }
  EXPECT_LT((near_sum.scatter - far_sum.scatter).norm(), 1e-6 * near_sum.scatter.norm());
}

TEST(PointCluster, MovesWithItsPoints) {
  Random random(6);
  Points points = RandomPoints(random, 50, {1.0, 0.0, -1.0});
  const Eigen::Matrix3d rotation = random.Rotation();
  const Eigen::Vector3d translation(10.0, -20.0, 30.0);
  const PointCluster moved = Transformed(rotation, translation, TwoPass(points));
  for (auto& p : points) p = rotation * p + translation;
  ExpectNear(moved, TwoPass(points), 1e-12);
}

}  // namespace
}  // namespace backsight
