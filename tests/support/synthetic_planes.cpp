#include "tests/support/synthetic_planes.h"

#include <algorithm>

#include "core/voxel_grid.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

using Normals = SyntheticPlaneOptions::Normals;

/// World frame of a patch: its normal is the third axis.
RigidTransform PatchFrame(Random& random, Normals normals) {
  RigidTransform frame{random.Rotation(), RandomPoint(random, 10.0)};
  if (normals == Normals::kAny) return frame;
  const auto axis = normals == Normals::kParallel ? 2 : static_cast<int>(random.Index(3));
  frame.rotation << Eigen::Vector3d::Unit((axis + 1) % 3), Eigen::Vector3d::Unit((axis + 2) % 3),
      Eigen::Vector3d::Unit(axis);
  frame.translation[axis] = random.Uniform() < 0.5 ? -10.0 : 10.0;
  return frame;
}

}  // namespace

SyntheticPlanes MakePlanes(std::uint64_t seed, const SyntheticPlaneOptions& options) {
  Random random(seed);
  SyntheticPlanes scene;
  for (int s = 0; s < options.stations; ++s) {
    scene.world_from_station.push_back(s == 0 ? RigidTransform{} : RandomTransform(random, 8.0));
  }
  const auto stations = static_cast<std::uint64_t>(options.stations);
  while (scene.planes.size() < static_cast<std::size_t>(options.planes)) {
    const RigidTransform world_from_patch = PatchFrame(random, options.normals);
    const std::uint64_t first = random.Index(stations);
    const std::uint64_t second =
        (first + 1 + random.Index(std::max<std::uint64_t>(stations, 2) - 1));
    WeightedPlane plane;
    double count = 0.0;
    for (std::uint64_t s = 0; s < stations; ++s) {
      const bool sees = s == first || s == second % stations || random.Uniform() < 0.5;
      if (!sees && !options.seen_by_all) continue;
      const RigidTransform station_from_world = scene.world_from_station[s].Inverse();
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < options.points; ++i) {
        const Eigen::Vector3d on_patch(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), 0.0);
        points.push_back(station_from_world * (world_from_patch * on_patch) +
                         RandomNoise(random, options.noise_m));
      }
      plane.observations.push_back({static_cast<int>(s), ClusterOf(points)});
      count += options.points;
    }
    const double sigma = std::max(options.noise_m, 0.001);
    plane.weight = count / (2.0 * sigma * sigma);
    scene.planes.push_back(std::move(plane));
  }
  return scene;
}

std::vector<RigidTransform> Disturbed(Random& random, const std::vector<RigidTransform>& poses,
                                      int fixed, double angle_rad, double distance_m) {
  std::vector<RigidTransform> disturbed = poses;
  for (std::size_t s = 0; s < poses.size(); ++s) {
    if (static_cast<int>(s) == fixed) continue;
    // About the station itself, so that the angle does not move it.
    const RigidTransform noise{ExpSo3(angle_rad * random.Rotation().col(0)),
                               distance_m * random.Rotation().col(0)};
    disturbed[s] = {noise.rotation * poses[s].rotation, poses[s].translation + noise.translation};
  }
  return disturbed;
}

PointCluster ClusterOf(const std::vector<Eigen::Vector3d>& points) {
  PointCluster cluster;
  cluster.count = static_cast<double>(points.size());
  for (const auto& p : points) cluster.mean += p / cluster.count;
  for (const auto& p : points) {
    cluster.scatter += (p - cluster.mean) * (p - cluster.mean).transpose();
  }
  return cluster;
}

std::vector<PointCluster> StationClusters(const std::vector<Eigen::Vector3d>& world_points,
                                          const RigidTransform& world_from_station) {
  VoxelClusterer clusterer({.edge_m = 0.1});
  const RigidTransform station_from_world = world_from_station.Inverse();
  for (const auto& p : world_points) clusterer.Add(station_from_world * p);
  std::vector<PointCluster> clusters;
  const VoxelLeaves leaves = clusterer.Finish();
  for (std::size_t i = 0; i < leaves.size(); ++i) clusters.push_back(leaves.Cluster(i));
  return clusters;
}

std::vector<Eigen::Vector3d> RoomPoints(Random& random, const Eigen::Vector3d& low,
                                        const Eigen::Vector3d& high, double spacing_m,
                                        double noise_m) {
  std::vector<Eigen::Vector3d> points;
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    const double area = (high[a] - low[a]) * (high[b] - low[b]);
    const int n = static_cast<int>(area / (spacing_m * spacing_m));
    for (int i = 0; i < 2 * n; ++i) {
      Eigen::Vector3d p;
      p[axis] = (i % 2 == 0 ? low[axis] : high[axis]) + noise_m * random.Normal();
      p[a] = random.Uniform(low[a], high[a]);
      p[b] = random.Uniform(low[b], high[b]);
      points.push_back(p);
    }
  }
  return points;
}

}  // namespace backsight
