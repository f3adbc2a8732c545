#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "stages/surface.h"

namespace backsight {

/// At which angle a station's beams met its surfaces. The normal is that of the point's voxel
/// (StationFeatures::normals), and it is credible where the voxel's own points lie within an eighth
/// of its edge (root mean square) of the plane with that normal: not where walls meet, and not in
/// leaves and grass. Not thread-safe: it remembers the voxel of the last point, as neighbours are
/// often scanned together; another voxel costs O(log voxels). Adds no memory to the model's.
class SurfaceIncidence {
 public:
  /// Refers to the surface's model and normals, which must outlive it.
  explicit SurfaceIncidence(const Surface& surface) : surface_(surface) {}

  /// Cosine of the angle between beam and normal, 0 to 1, of a point in the station frame, metres,
  /// or nothing where no credible normal is known.
  std::optional<double> CosAt(const Eigen::Vector3d& station_point);

 private:
  void FindLeaf(std::uint64_t key);

  Surface surface_;
  std::size_t leaf_ = 0;                   // near the last point
  std::optional<std::uint64_t> key_;       // of the last point's voxel
  std::optional<Eigen::Vector3d> normal_;  // there, if credible
};

}  // namespace backsight
