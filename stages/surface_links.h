#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/execution.h"
#include "core/voxel_index.h"
#include "graph/planar_statistics.h"
#include "graph/pose_graph.h"
#include "stages/station_model.h"

namespace backsight {

/// What the voxels outside all adjusted planes say of the links' relative poses, at given poses.
struct SurfaceObservations {
  /// Each link's own minimum, one Gauss-Newton step away, with the matrix of that step: as a soft
  /// observation it has the surfaces' gradient and Gauss-Newton matrix.
  std::vector<PoseGraphLink> links;
  std::vector<LinkScore> scores;  ///< the same by blocks of space
  int matches = 0;
};

/// Generalised ICP (Segal et al. 2009, doi 10.15607/RSS.2009.V.021) between linked stations on the
/// voxels that no adjusted plane covers: curved and small surfaces.
class SurfaceMatcher {
 public:
  /// `covered(s, i)`: voxel i of station s is part of a plane. `normals[s]` per leaf, NaN where
  /// undefined. Keeps the uncovered voxels, 30 bytes each beside
  /// their index's bricks.
  SurfaceMatcher(std::span<const StationModel* const> stations,
                 std::span<const std::vector<Eigen::Vector3f>* const> normals,
                 const std::function<bool(std::size_t, std::size_t)>& covered,
                 const ExecutionContext& context);

  /// Nearest voxels within two edges and 30 degrees of normal. A match's covariance is the voxels'
  /// edge squared along the surface and, across it, what the link's own matches show (median
  /// absolute distance), divided by `information_factor`. Links with fewer than 100 matches observe
  /// nothing. At most two million matches in all, evenly chosen.
  SurfaceObservations Observe(std::span<const PoseGraphLink> links,
                              std::span<const RigidTransform> poses, double block_m,
                              double information_factor, const ExecutionContext& context) const;

 private:
  struct Voxels {
    VoxelPoints means;
    std::vector<Eigen::Vector3f> normals;
    std::unique_ptr<VoxelIndex> index;
  };
  struct Match;
  struct LinkResult;
  std::vector<Match> FindMatches(const PoseGraphLink& link,
                                 const RigidTransform& target_from_source,
                                 std::size_t sample) const;
  LinkResult ObserveLink(const PoseGraphLink& link, std::span<const RigidTransform> poses,
                         double block_m, double information_factor, std::size_t sample) const;

  double l_ = 0.0;
  std::vector<Voxels> voxels_;
};

}  // namespace backsight
