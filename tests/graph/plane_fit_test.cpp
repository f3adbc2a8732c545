#include "graph/plane_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "core/random.h"

namespace backsight {
namespace {

Eigen::Vector3d RandomPoint(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

/// Clusters of a few points on a tilted plate a metre wide and some millimetres thick, `away` from
/// the origin.
std::vector<PointCluster> Plate(std::uint64_t seed, std::size_t count, double away) {
  Random random(seed);
  const Eigen::Matrix3d axes =
      Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), random.Normal())
          .normalized()
          .toRotationMatrix();
  const Eigen::Vector3d place = away * RandomPoint(&random);
  std::vector<PointCluster> clusters(count);
  for (PointCluster& cluster : clusters) {
    for (std::size_t n = 0; n < 1 + random.Index(6); ++n) {
      const Eigen::Vector3d within(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5),
                                   0.003 * random.Normal());
      cluster += {1.0, place + axes * within, Eigen::Matrix3d::Zero()};
    }
  }
  return clusters;
}

TEST(ClusterSum, EqualsTheSumOneByOne) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    PointCluster expected;
    ClusterSum sum;
    for (const PointCluster& cluster : Plate(seed, 1 + 7 * seed, 100.0)) {
      expected += cluster;
      sum.Add(cluster);
    }
    const PointCluster actual = sum.Sum();
    EXPECT_EQ(actual.count, expected.count);
    EXPECT_LT((actual.mean - expected.mean).norm(), 1e-12);  // of coordinates of 100 m
    // The scatter across the plate is 1e-5 of that along it; differences of 100 m round to 1e-14.
    EXPECT_LT((actual.scatter - expected.scatter).norm(), 1e-11 * expected.scatter.norm());
    EXPECT_EQ(actual.scatter, actual.scatter.transpose());
  }
}

TEST(FitPlanes, EqualsTheIterativeSolverForAnyNumberOfClusters) {
  for (const std::size_t count : {1U, 2U, 7U, 8U, 9U, 30U}) {
    std::vector<PointCluster> clusters;
    for (std::size_t i = 0; i < count; ++i) {
      PointCluster sum;
      for (const PointCluster& cluster : Plate(100 * count + i, 40, 10.0)) sum += cluster;
      clusters.push_back(sum);
    }
    std::vector<PlaneFit> fits(count);
    FitPlanes(clusters, /*normals=*/true, fits);
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(clusters[i].Covariance());
      EXPECT_LT((fits[i].eigenvalues - solver.eigenvalues()).norm(),
                1e-14 * solver.eigenvalues()[2]);
      EXPECT_GT(std::abs(fits[i].normal.dot(solver.eigenvectors().col(0))), 1.0 - 1e-12);
      EXPECT_NEAR(fits[i].normal.norm(), 1.0, 1e-14);
    }
    std::vector<PlaneFit> values(count);
    FitPlanes(clusters, /*normals=*/false, values);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(values[i].eigenvalues, fits[i].eigenvalues);
      EXPECT_TRUE(values[i].normal.isZero());
    }
  }
}

}  // namespace
}  // namespace backsight
