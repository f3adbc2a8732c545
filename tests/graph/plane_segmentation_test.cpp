#include "graph/plane_segmentation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>

#include "tests/support/matchers.h"
#include "tests/support/synthetic_planes.h"

namespace backsight {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// What several stations saw, and where they stood.
struct Seen {
  std::vector<std::vector<PointCluster>> clusters;
  std::vector<RigidTransform> poses;

  void Add(const Points& world_points, const RigidTransform& world_from_station) {
    clusters.push_back(StationClusters(world_points, world_from_station));
    poses.push_back(world_from_station);
  }
  std::vector<PlaneAssociation> Find(const PlaneSearchOptions& options = {}) const {
    std::vector<const std::vector<PointCluster>*> pointers;
    for (const auto& c : clusters) pointers.push_back(&c);
    return FindPlanes(pointers, poses, options);
  }
  PointCluster World(const PlaneObservation& o) const {
    const RigidTransform& pose = poses[static_cast<std::size_t>(o.station)];
    return Transformed(pose.rotation, pose.translation, o.cluster);
  }
};

const Eigen::Vector3d kLow(-3.1, -2.3, -1.2);
const Eigen::Vector3d kHigh(3.3, 2.5, 1.6);

Seen MakeRoom(std::uint64_t seed, int stations, const RigidTransform& new_from_world = {}) {
  Random random(seed);
  Seen seen;
  for (int s = 0; s < stations; ++s) {
    Points points = RoomPoints(random, kLow, kHigh, 0.03, 0.003);
    for (auto& p : points) p = new_from_world * p;
    seen.Add(points, new_from_world * RandomTransform(random, 1.0));
  }
  return seen;
}

/// A square patch of half edge 0.35 m about (0.4, 0.4, z), inside one root cell.
Points Patch(Random& random, double z, int n) {
  Points points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(random.Uniform(0.05, 0.75), random.Uniform(0.05, 0.75),
                        z + 0.003 * random.Normal());
  }
  return points;
}

TEST(FindPlanes, FindsEveryWallOfARoom) {
  const Seen room = MakeRoom(1, 2);
  const auto planes = room.Find();
  int on_wall[6] = {};
  for (const PlaneAssociation& plane : planes) {
    ASSERT_EQ(plane.observations.size(), 2U);
    EXPECT_EQ(plane.observations[0].station, 0);
    EXPECT_EQ(plane.observations[1].station, 1);
    const PointCluster joint =
        room.World(plane.observations[0]) + room.World(plane.observations[1]);
    int walls = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        const double wall = side == 0 ? kLow[axis] : kHigh[axis];
        // A sliver of the next wall may lie in a cell, within the thickness allowed.
        if (std::abs(joint.mean[axis] - wall) > 0.05) continue;
        EXPECT_LT(std::sqrt(joint.Covariance()(axis, axis)), 0.05);
        ++on_wall[2 * axis + side];
        ++walls;
      }
    }
    EXPECT_GE(walls, 1) << joint.mean.transpose();
  }
  for (const int n : on_wall) EXPECT_GT(n, 10);
}

TEST(FindPlanes, ObservationsAreSumsInStationFrames) {
  const Seen room = MakeRoom(2, 2);
  for (int s = 0; s < 2; ++s) {
    double total = 0.0;
    for (const auto& cluster : room.clusters[static_cast<std::size_t>(s)]) total += cluster.count;
    double used = 0.0;
    for (const auto& plane : room.Find()) {
      const auto& cluster = plane.observations[static_cast<std::size_t>(s)].cluster;
      used += cluster.count;
      EXPECT_TRUE(cluster.mean.allFinite());
    }
    EXPECT_LE(used, total) << "no voxel may count twice";
    EXPECT_GT(used, 0.6 * total);
  }
}

TEST(FindPlanes, OrderIsDeterministicAndRepeatable) {
  const Seen room = MakeRoom(3, 3);
  const auto a = room.Find();
  const auto b = room.Find();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].observations.size(), b[k].observations.size());
    for (std::size_t o = 0; o < a[k].observations.size(); ++o) {
      EXPECT_EQ(a[k].observations[o].station, b[k].observations[o].station);
      EXPECT_EQ(a[k].observations[o].cluster.mean, b[k].observations[o].cluster.mean);
      if (o > 0) {
        EXPECT_LT(a[k].observations[o - 1].station, a[k].observations[o].station);
      }
    }
  }
}

TEST(FindPlanes, RotatedLatticeFindsSimilarMany) {
  Random random(4);
  const auto straight = static_cast<double>(MakeRoom(4, 2).Find().size());
  for (int k = 0; k < 4; ++k) {
    const auto turned =
        static_cast<double>(MakeRoom(4, 2, RandomTransform(random, 50.0)).Find().size());
    EXPECT_GT(turned, 0.6 * straight);
    EXPECT_LT(turned, 2.5 * straight);
  }
}

TEST(FindPlanes, RespectsTheLeastNumberOfPoints) {
  Random random(5);
  Seen seen;
  seen.Add(Patch(random, 0.4, 400), {});
  seen.Add(Patch(random, 0.4, 12), {});
  const PlaneSearchOptions by_points{.max_depth = 0, .min_points = 15.0, .min_clusters = 100};
  EXPECT_TRUE(seen.Find(by_points).empty());
  EXPECT_EQ(seen.Find({.max_depth = 0, .min_points = 12.0, .min_clusters = 100}).size(), 1U);
  EXPECT_EQ(seen.Find({.max_depth = 0, .min_points = 15.0, .min_clusters = 5}).size(), 1U)
      << "enough voxels make up for few points";
}

TEST(FindPlanes, RejectsEdgesLinesAndSpheres) {
  Random random(6);
  Points edge;
  Points line;
  Points sphere;
  for (int i = 0; i < 600; ++i) {
    const double a = random.Uniform(0.1, 0.7);
    edge.push_back(i % 2 == 0 ? Eigen::Vector3d(random.Uniform(0.1, 0.4), a, 0.4)
                              : Eigen::Vector3d(0.4, a, random.Uniform(0.1, 0.4)));
    line.push_back(Eigen::Vector3d(a, 0.4, 0.4) + RandomNoise(random, 0.004));
    sphere.push_back(Eigen::Vector3d(0.4, 0.4, 0.4) + 0.3 * random.Rotation().col(0));
  }
  for (const Points& points : {edge, line, sphere}) {
    Seen seen;
    seen.Add(points, {});
    seen.Add(points, RandomTransform(random, 2.0));
    EXPECT_TRUE(seen.Find({.max_depth = 0}).empty());
  }
  Seen seen;  // split, the two faces of the edge are planes
  seen.Add(edge, {});
  seen.Add(edge, {});
  const auto faces = seen.Find({.max_depth = 2});
  EXPECT_GE(faces.size(), 2U);
}

TEST(FindPlanes, DropsTheStationWhoseSurfaceIsOffset) {
  for (const double offset : {0.2, 0.35}) {
    for (std::size_t odd = 0; odd < 3; ++odd) {
      Random random(7);
      Seen seen;
      for (std::size_t s = 0; s < 3; ++s) {
        seen.Add(Patch(random, s == odd ? 0.2 + offset : 0.2, 400), RandomTransform(random, 2.0));
      }
      const auto planes = seen.Find({.max_depth = 0});
      ASSERT_EQ(planes.size(), 1U) << offset << " " << odd;
      ASSERT_EQ(planes[0].observations.size(), 2U);
      for (const auto& o : planes[0].observations) {
        EXPECT_NE(o.station, static_cast<int>(odd));
      }
    }
  }
}

TEST(FindPlanes, DropsTheStationWhoseSurfaceIsTilted) {
  Random random(8);
  Seen seen;
  for (int s = 0; s < 4; ++s) {
    Points points = Patch(random, 0.4, 400);
    if (s == 1) {
      for (auto& p : points) p.z() += 0.4 * (p.x() - 0.4);  // 22 deg
    }
    seen.Add(points, RandomTransform(random, 2.0));
  }
  const auto planes = seen.Find({.max_depth = 0});
  ASSERT_EQ(planes.size(), 1U);
  ASSERT_EQ(planes[0].observations.size(), 3U);
  for (const auto& o : planes[0].observations) EXPECT_NE(o.station, 1);
}

TEST(FindPlanes, OneStationOrNoneMakesNoPlane) {
  EXPECT_TRUE(Seen{}.Find().empty());
  EXPECT_TRUE(MakeRoom(9, 1).Find().empty());
  Seen seen = MakeRoom(9, 1);
  seen.clusters.emplace_back();
  seen.poses.emplace_back();
  EXPECT_TRUE(seen.Find().empty());
}

}  // namespace
}  // namespace backsight
