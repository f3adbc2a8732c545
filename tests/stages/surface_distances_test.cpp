#include "stages/surface_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/random.h"
#include "core/voxel_grid.h"
#include "stages/surface_patch.h"

namespace backsight {
namespace {

constexpr double kEdge = 0.1;

/// A wall and a piece of floor amid voxels, 4 m wide, measured every 12 mm with 1 mm of noise
/// across.
StationModel Corner(std::uint64_t seed) {
  Random random(seed);
  StationModel model;
  VoxelClusterer clusterer({.edge_m = kEdge});
  for (double u = -2.0; u < 2.0; u += 0.012) {
    for (double v = 0.0; v < 2.0; v += 0.012) {
      clusterer.Add({u, 3.05 + 0.001 * random.Normal(), v - 1.05});
      clusterer.Add({u, 3.05 - v, -1.05 + 0.001 * random.Normal()});
    }
  }
  model.leaves = clusterer.Finish();
  return model;
}

struct Stations {
  std::vector<std::unique_ptr<StationModel>> models;
  std::vector<std::unique_ptr<CloudIndex>> indices;
  std::vector<Eigen::Vector3f> normals;
  std::vector<PlacedCloud> clouds;

  void Add(const RigidTransform& frame_from_instrument, int component = 0) {
    models.push_back(std::make_unique<StationModel>(Corner(models.size() + 1)));
    indices.push_back(std::make_unique<CloudIndex>(*models.back()));
    clouds.push_back(
        {{*models.back(), normals, true}, *indices.back(), frame_from_instrument, component});
  }
};

double Median(std::vector<DistanceSample> samples, const auto& wanted) {
  std::erase_if(samples, [&](const DistanceSample& s) { return !wanted(s.position); });
  EXPECT_GT(samples.size(), 500U);
  std::sort(samples.begin(), samples.end(),
            [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  return samples[samples.size() / 2].distance_m;
}

bool OnWall(const Eigen::Vector3d& p) { return p.z() > -0.7; }
bool OnFloor(const Eigen::Vector3d& p) { return p.y() < 2.7; }

TEST(SurfaceDistances, MeasureAKnownShift) {
  Stations stations;
  stations.Add({});
  RigidTransform shifted;
  shifted.translation = {0.02, 0.003, 0.0};  // 3 mm across the wall, along the floor
  stations.Add(shifted);
  const SurfaceDistances distances = MeasureSurfaceDistances(stations.clouds, ExecutionContext(1));
  ASSERT_EQ(distances.pairs.size(), 1U);
  EXPECT_EQ(distances.search_m, 2.0 * kEdge);
  EXPECT_NEAR(Median(distances.pairs[0].samples, OnWall), 0.003, 0.0002);
  EXPECT_NEAR(Median(distances.pairs[0].samples, OnFloor), 0.0, 0.0002);
}

TEST(SurfacePatch, RingsOnTheGroundAreNoSurfaceUntilTwoOfThemAre) {
  Random random(3);
  // The ground 1.5 m below a scanner, seen at 20 m under 4 degrees; 2 mm of noise along the beam.
  const auto ring = [&](double radius) {
    VoxelClusterer all({10.0, Eigen::Vector3d::Zero()});
    for (double angle = 0.02; angle < 0.03; angle += 0.0005) {
      const Eigen::Vector3d beam =
          Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), -1.5 + 10.0)
              .normalized();
      all.Add(Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 1.5) +
              0.002 * random.Normal() * beam);
    }
    return all.Finish().Cluster(0);
  };
  const PointCluster near = ring(21.0);
  EXPECT_FALSE(PatchOf(near, kEdge));
  const auto both = PatchOf(near + ring(21.12), kEdge);
  ASSERT_TRUE(both);
  EXPECT_GT(std::abs(both->normal.z()), 0.99);
}

TEST(SurfaceDistances, DoNotDependOnThreads) {
  Stations stations;
  for (int i = 0; i < 3; ++i) {
    stations.Add({Eigen::Matrix3d::Identity(), {0.0, 0.001 * i, 0.001 * i}});
  }
  const auto one = MeasureSurfaceDistances(stations.clouds, ExecutionContext(1));
  const auto four = MeasureSurfaceDistances(stations.clouds, ExecutionContext(4));
  ASSERT_EQ(one.pairs.size(), 3U);
  ASSERT_EQ(four.pairs.size(), 3U);
  for (std::size_t p = 0; p < 3; ++p) {
    ASSERT_EQ(one.pairs[p].samples.size(), four.pairs[p].samples.size());
    for (std::size_t i = 0; i < one.pairs[p].samples.size(); ++i) {
      EXPECT_EQ(one.pairs[p].samples[i].distance_m, four.pairs[p].samples[i].distance_m);
    }
  }
}

TEST(SurfaceDistances, NeedACommonFrameAndTheSameSide) {
  Stations apart;
  apart.Add({});
  apart.Add({}, /*component=*/1);
  EXPECT_TRUE(MeasureSurfaceDistances(apart.clouds, ExecutionContext(1)).pairs.empty());

  // Seen from behind, 50 mm of wall away: not the same surface.
  Stations behind;
  behind.Add({});
  RigidTransform turned;
  turned.rotation = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
  turned.translation = {0.0, 6.15, 0.0};
  behind.Add(turned);
  for (const auto& pair : MeasureSurfaceDistances(behind.clouds, ExecutionContext(1)).pairs) {
    for (const DistanceSample& sample : pair.samples) EXPECT_FALSE(OnWall(sample.position));
  }
  EXPECT_TRUE(MeasureSurfaceDistances({}, ExecutionContext(1)).pairs.empty());
}

}  // namespace
}  // namespace backsight
