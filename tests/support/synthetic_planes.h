#pragma once

#include <vector>

#include "core/point_cluster.h"
#include "core/random.h"
#include "core/rigid_transform.h"
#include "graph/planar_cost.h"

namespace backsight {

struct SyntheticPlaneOptions {
  enum class Normals { kAny, kBox, kParallel };
  int stations = 3;
  int planes = 60;
  int points = 40;       ///< per plane and station that sees it
  double noise_m = 0.0;  ///< per axis
  Normals normals = Normals::kAny;
  bool seen_by_all = false;  ///< otherwise by two or more stations at random
};

/// Plane patches of 1 m within a room of 20 m x 20 m x 20 m, with associations and poses known.
/// Weights are honest: points / (2 noise^2), so that the Gauss-Newton matrix is the information.
struct SyntheticPlanes {
  std::vector<RigidTransform> world_from_station;  ///< station 0 at the origin
  std::vector<WeightedPlane> planes;
};

SyntheticPlanes MakePlanes(std::uint64_t seed, const SyntheticPlaneOptions& options);

/// All poses but `fixed` retracted by random twists of the given size.
std::vector<RigidTransform> Disturbed(Random& random, const std::vector<RigidTransform>& poses,
                                      int fixed, double angle_rad, double distance_m);

/// Cluster of points straight from the definition.
PointCluster ClusterOf(const std::vector<Eigen::Vector3d>& points);

/// Voxel clusters (edge 0.1 m) of world points as a station sees them, in its own frame.
std::vector<PointCluster> StationClusters(const std::vector<Eigen::Vector3d>& world_points,
                                          const RigidTransform& world_from_station);

/// Points on the six walls of a room between two corners, `spacing_m` apart, with noise.
std::vector<Eigen::Vector3d> RoomPoints(Random& random, const Eigen::Vector3d& low,
                                        const Eigen::Vector3d& high, double spacing_m,
                                        double noise_m);

}  // namespace backsight
