#include "core/cluster_spread.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/archive.h"
#include "core/error.h"
#include "core/random.h"
#include "core/rigid_transform.h"
#include "core/voxel_leaves.h"
#include "core/voxel_spread.h"

namespace backsight {
namespace {

const Eigen::Vector3d kMiddle = Eigen::Vector3d::Zero();

PointCluster ClusterOf(const std::vector<Eigen::Vector3d>& points) {
  PointCluster all;
  for (const Eigen::Vector3d& point : points) {
    all += PointCluster{1.0, point, Eigen::Matrix3d::Zero()};
  }
  return all;
}

/// Points spread by `sigmas` along axes that are turned at random.
PointCluster PointsSpread(Random& random, const Eigen::Vector3d& sigmas, int count) {
  const auto uniform = [&](double reach) {
    return Eigen::Vector3d(random.Uniform(-reach, reach), random.Uniform(-reach, reach),
                           random.Uniform(-reach, reach));
  };
  const RigidTransform place{ExpSo3(uniform(3.0)), uniform(50.0)};
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d normal(random.Normal(), random.Normal(), random.Normal());
    points.push_back(place * sigmas.cwiseProduct(normal));
  }
  return ClusterOf(points);
}

Eigen::Vector3d ExtentsOf(const PointCluster& cluster) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(cluster.Covariance());
  return axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

struct Precision {
  double extent;   // of the largest extent
  double scatter;  // of the scatter's norm
};

template <class Spread>
struct SpreadTest : testing::Test {};
template <class Spread>
constexpr Precision kPrecision{1e-7, 3e-7};
template <>
constexpr Precision kPrecision<VoxelSpread>{1e-4, 1e-4};

using Spreads = testing::Types<ClusterSpread, VoxelSpread>;
TYPED_TEST_SUITE(SpreadTest, Spreads);

TYPED_TEST(SpreadTest, ChangesNoExtentByMoreThanItsPrecision) {
  Random random(5);
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d sigmas(1.0, std::pow(10.0, random.Uniform(-4.0, 0.0)),
                                 std::pow(10.0, random.Uniform(-7.0, 0.0)));
    const double size = std::pow(10.0, random.Uniform(-3.0, 2.0));
    const PointCluster cluster = PointsSpread(random, size * sigmas, 3 + k % 40);
    const PointCluster back = TypeParam(cluster).About(cluster.mean);
    EXPECT_EQ(back.count, cluster.count);
    EXPECT_EQ(back.mean, cluster.mean);
    EXPECT_EQ(back.scatter, back.scatter.transpose());
    const Eigen::Vector3d expected = ExtentsOf(cluster);
    constexpr Precision precision = kPrecision<TypeParam>;
    EXPECT_LT((ExtentsOf(back) - expected).cwiseAbs().maxCoeff(), precision.extent * expected[2]);
    EXPECT_LT((back.scatter - cluster.scatter).norm(), precision.scatter * cluster.scatter.norm());
  }
}

TYPED_TEST(SpreadTest, MakesSurfacesNeitherThickerNorThinner) {
  Random random(9);
  constexpr int kSurfaces = 4000;
  double change = 0.0;
  for (int k = 0; k < kSurfaces; ++k) {  // 1 mm of noise where a voxel of 0.1 m is filled
    const PointCluster cluster = PointsSpread(random, {0.03, 0.03, 1e-3}, 30);
    const PointCluster back = TypeParam(cluster).About(cluster.mean);
    change += (ExtentsOf(back)[0] - ExtentsOf(cluster)[0]) / kSurfaces;
  }
  EXPECT_LT(std::abs(change), 5e-8) << "m of 1e-3";
}

TYPED_TEST(SpreadTest, StaysWhatItIsWhenPackedAgain) {
  Random random(6);
  for (int k = 0; k < 200; ++k) {
    const PointCluster once = TypeParam(PointsSpread(random, {0.1, 0.05, 1e-3}, 20)).About(kMiddle);
    const PointCluster twice = TypeParam(once).About(kMiddle);
    EXPECT_LT((twice.scatter - once.scatter).norm(), 1e-15 * once.scatter.norm()) << k;
  }
}

TYPED_TEST(SpreadTest, KeepsPointsLinesAndPlanesAlongTheAxes) {
  for (const Eigen::Vector3d& sides : std::vector<Eigen::Vector3d>{
           {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}}) {
    const Eigen::Matrix3d scatter = sides.asDiagonal();
    const PointCluster back = TypeParam({7.0, kMiddle, scatter}).About({1.0, 2.0, 3.0});
    EXPECT_EQ(back.scatter, scatter);
    EXPECT_EQ(back.mean, Eigen::Vector3d(1.0, 2.0, 3.0));
    EXPECT_EQ(back.count, 7.0);
  }
}

TYPED_TEST(SpreadTest, TakesWhatRoundingLeavesOfASinglePointAsNothing) {
  Random random(7);
  for (int k = 0; k < 1000; ++k) {  // neither symmetric in its rounding nor positive
    Eigen::Matrix3d noise;
    for (int i = 0; i < 9; ++i) {
      noise(i / 3, i % 3) = 1e-18 * random.Normal() * std::pow(10.0, random.Uniform(-16.0, 0.0));
    }
    const PointCluster back = TypeParam({1.0, kMiddle, noise}).About(kMiddle);
    ASSERT_TRUE(back.scatter.allFinite());
    EXPECT_LT(back.scatter.norm(), 1e-16) << noise;
  }
}

TYPED_TEST(SpreadTest, RefusesWhatItCannotCount) {
  const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
  for (const double count : {0.0, 1.0, 65535.0, 65536.0, 0x1p32 - 1.0}) {
    EXPECT_EQ(TypeParam({count, kMiddle, none}).About(kMiddle).count, count);
  }
  for (const double count : {0x1p32, -1.0, 0.5, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(TypeParam({count, kMiddle, none}), InternalError) << count;
  }
}

TEST(VoxelSpread, TakesWhatVanishesWhenSquaredAsNothing) {
  const Eigen::Matrix3d tiny = 1e-300 * Eigen::Matrix3d::Identity();
  const VoxelSpread spread({3.0, kMiddle, tiny});
  EXPECT_EQ(spread.About(kMiddle).scatter, Eigen::Matrix3d::Zero());
  EXPECT_EQ(FromBytes<VoxelSpread>(ToBytes(spread)).count(), 3.0);
  EXPECT_THROW(VoxelSpread({3.0, kMiddle, 1e300 * Eigen::Matrix3d::Identity()}), InternalError);
}

TEST(VoxelSpread, OfDamagedArchivesIsRefused) {
  const VoxelSpread spread({3.0, kMiddle, Eigen::Matrix3d::Identity()});
  std::string bytes = ToBytes(spread);
  EXPECT_EQ(FromBytes<VoxelSpread>(bytes).About(kMiddle).scatter, Eigen::Matrix3d::Identity());
  constexpr std::size_t kExponentAt = 6 * sizeof(std::int16_t);
  for (const int value : {401, -401, 32767, -32768}) {
    const auto exponent = static_cast<std::int16_t>(value);
    std::memcpy(bytes.data() + kExponentAt, &exponent, sizeof(exponent));
    EXPECT_THROW(FromBytes<VoxelSpread>(bytes), DamagedArchive) << exponent;
  }
}

TEST(VoxelLeaves, OfDamagedArchivesAreRefused) {
  VoxelLeaves leaves({.edge_m = 0.5});
  leaves.Add(VoxelLattice::Pack({1, 2, 3}), {4.0, {0.7, 1.2, 1.6}, Eigen::Matrix3d::Identity()});
  std::string bytes = ToBytes(leaves);
  EXPECT_EQ(FromBytes<VoxelLeaves>(bytes).Mean(0), leaves.Mean(0));
  constexpr std::size_t kSpreadBytes = 18;
  bytes.resize(bytes.size() - kSpreadBytes);  // no spread, and their number says so
  bytes[bytes.size() - sizeof(std::uint64_t)] = 0;
  EXPECT_THROW(FromBytes<VoxelLeaves>(bytes), DamagedArchive);
}

TEST(VoxelLeaves, GiveBackWhatWasAddedAndMove) {
  Random random(8);
  const VoxelLattice lattice{.edge_m = 0.5};
  VoxelLeaves leaves(lattice);
  std::vector<PointCluster> clusters;
  for (int i = 0; i < 50; ++i) {
    clusters.push_back(PointsSpread(random, {0.1, 0.1, 0.01}, 9));
    leaves.Add(lattice.Key(clusters.back().mean), clusters.back());
  }
  const Eigen::Vector3d by(3.0, -2.0, 1.0);
  leaves.Translate(by);
  ASSERT_EQ(leaves.size(), 50U);
  EXPECT_FALSE(leaves.empty());
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(leaves.Key(i), lattice.Key(clusters[i].mean));
    EXPECT_EQ(leaves.keys()[i], leaves.Key(i));
    EXPECT_EQ(leaves.Count(i), 9.0);
    EXPECT_LT((leaves.Mean(i) - clusters[i].mean - by).lpNorm<Eigen::Infinity>(), 0x1.01p-17 * 0.5);
    EXPECT_EQ(leaves.means()[i], leaves.Mean(i));
    EXPECT_EQ(leaves.Cluster(i).mean, leaves.Mean(i));
    EXPECT_LT((leaves.Cluster(i).scatter - clusters[i].scatter).norm(),
              1e-4 * clusters[i].scatter.norm());
  }
}

}  // namespace
}  // namespace backsight
