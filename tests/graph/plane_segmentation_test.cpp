#include "graph/plane_segmentation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <utility>

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

/// The search straight from its definition: no keys, no sorting, every cloud gone through anew for
/// every cell.
struct NaiveSearch {
  const Seen& seen;
  const PlaneSearchOptions& options;
  std::vector<std::vector<std::pair<int, double>>> found;  // stations and counts of each plane

  static bool Inside(const Eigen::Vector3d& p, const Eigen::Vector3d& low, double edge) {
    return ((p - low).array() >= 0.0).all() && ((p - low).array() < edge).all();
  }
  static Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> Solve(const PointCluster& c) {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(c.Covariance());
  }
  bool Planar(const PointCluster& c) const {
    const Eigen::Vector3d e = Solve(c).eigenvalues();
    return e[0] < options.max_thinness * e[1] && e[1] > options.min_width * e[2] &&
           std::sqrt(std::max(e[0], 0.0)) < options.max_thickness_m;
  }
  double Misfit(const PointCluster& c, const PointCluster& joint) const {
    const auto solver = Solve(joint);
    const Eigen::Vector3d normal = solver.eigenvectors().col(0);
    const Eigen::Vector3d offset = c.mean - joint.mean;
    const double along = (offset - offset.dot(normal) * normal).norm();
    const double cosine = std::abs(Solve(c).eigenvectors().col(0).dot(normal));
    return std::max({std::acos(std::min(cosine, 1.0)) / options.max_angle_rad,
                     std::abs(offset.dot(normal)) / options.max_offset_m,
                     along / (2.0 * std::sqrt(solver.eigenvalues()[2]))});
  }

  void Cell(const Eigen::Vector3d& low, double edge, int depth) {
    std::map<int, PointCluster> parts;
    for (std::size_t s = 0; s < seen.poses.size(); ++s) {
      PointCluster part;
      int clusters = 0;
      for (const PointCluster& c : seen.clusters[s]) {
        if (!Inside(seen.poses[s] * c.mean, low, edge)) continue;
        part += Transformed(seen.poses[s].rotation, seen.poses[s].translation, c);
        ++clusters;
      }
      if (part.count >= options.min_points || clusters >= options.min_clusters) {
        parts[static_cast<int>(s)] = part;
      }
    }
    if (parts.size() < 2) return;
    auto planar = parts;
    std::erase_if(planar, [&](const auto& part) { return !Planar(part.second); });
    while (planar.size() >= 2) {
      PointCluster joint;
      for (const auto& [s, part] : planar) joint += part;
      const auto worst =
          std::max_element(planar.begin(), planar.end(), [&](const auto& a, const auto& b) {
            return Misfit(a.second, joint) < Misfit(b.second, joint);
          });
      if (Misfit(worst->second, joint) < 1.0) {
        found.emplace_back();
        for (const auto& [s, part] : planar) found.back().emplace_back(s, part.count);
        return;
      }
      planar.erase(worst);
    }
    if (depth == options.max_depth) return;
    for (int o = 0; o < 8; ++o) {
      Cell(low + 0.5 * edge * Eigen::Vector3d(o / 4, o / 2 % 2, o % 2), 0.5 * edge, depth + 1);
    }
  }
};

TEST(FindPlanes, FindsWhatANaiveSearchFinds) {
  for (std::uint64_t seed = 20; seed < 22; ++seed) {
    Random random(seed);
    Seen seen;
    for (int s = 0; s < 3; ++s) {
      seen.Add(RoomPoints(random, {-1.3, -0.9, -0.7}, {1.1, 1.2, 1.3}, 0.04, 0.004),
               RandomTransform(random, 1.0));
    }
    const PlaneSearchOptions options;
    NaiveSearch naive{seen, options, {}};
    for (int x = -3; x < 3; ++x) {
      for (int y = -3; y < 3; ++y) {
        for (int z = -3; z < 3; ++z) {
          naive.Cell(options.root_edge_m * Eigen::Vector3d(x, y, z), options.root_edge_m, 0);
        }
      }
    }
    std::vector<std::vector<std::pair<int, double>>> found;
    for (const PlaneAssociation& plane : seen.Find(options)) {
      found.emplace_back();
      for (const PlaneObservation& o : plane.observations) {
        found.back().emplace_back(o.station, o.cluster.count);
      }
    }
    EXPECT_GT(found.size(), 40U);
    EXPECT_EQ(found, naive.found);
  }
}

TEST(FindPlanes, VoxelLeavesAndThreadsChangeNothingButRounding) {
  const Seen room = MakeRoom(10, 4);
  std::vector<VoxelLeaves> leaves;
  for (const auto& clusters : room.clusters) {
    leaves.emplace_back();
    for (const PointCluster& cluster : clusters) {
      leaves.back().Add(leaves.back().lattice().Key(cluster.mean), cluster);
    }
  }
  const std::vector<ClusterList> lists(leaves.begin(), leaves.end());
  const ExecutionContext four(4);
  const auto a = room.Find();
  const auto b = FindPlanes(lists, room.poses, {}, &four);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].cell, b[k].cell);
    ASSERT_EQ(a[k].observations.size(), b[k].observations.size());
    for (std::size_t o = 0; o < a[k].observations.size(); ++o) {
      EXPECT_EQ(a[k].observations[o].station, b[k].observations[o].station);
      EXPECT_EQ(a[k].observations[o].cluster.mean, b[k].observations[o].cluster.mean);
      const Eigen::Matrix3d& scatter = a[k].observations[o].cluster.scatter;
      EXPECT_LT((b[k].observations[o].cluster.scatter - scatter).norm(), 1e-6 * scatter.norm());
    }
  }
}

TEST(FindPlanes, CellsAreNamedByThePointsInThem) {
  const Seen room = MakeRoom(11, 2);
  const PlaneSearchOptions options;
  std::set<std::uint64_t> names;
  for (const PlaneAssociation& plane : room.Find(options)) {
    EXPECT_TRUE(names.insert(plane.cell).second) << "two planes in one cell";
    int matches = 0;
    for (int depth = 0; depth <= options.max_depth; ++depth) {
      const Eigen::Vector3d mean = room.World(plane.observations[0]).mean;
      matches += PlaneCell(mean, options.root_edge_m, depth) == plane.cell ? 1 : 0;
    }
    EXPECT_EQ(matches, 1);
  }
  EXPECT_GT(names.size(), 60U);
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
