#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>

#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Rays that belong together, such as the sub-rays of one laser beam. World frame, metres.
struct RayBundle {
  static constexpr std::size_t kSize = 8;
  std::array<Eigen::Vector3d, kSize> origins;
  std::array<Eigen::Vector3d, kSize> directions;  ///< unit vectors
  std::size_t count = kSize;                      ///< the first `count` rays are cast
};

struct RayHit {
  double range_m = 0.0;  ///< from the ray's origin; 0: nothing was hit
  double cos_incidence = 0.0;
  MaterialId material = 0;
  /// Plane of the hit triangle: normal . x = offset_m for x in the world frame.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset_m = 0.0;
};

using RayHits = std::array<RayHit, RayBundle::kSize>;

/// Nearest intersections of rays with a triangle mesh (Embree). The library finds the triangle in
/// single precision; the range is then computed from the triangle in double, so that it is exact to
/// rounding and does not depend on the processor's vector width. Cast is thread-safe.
class RayCaster {
 public:
  /// Builds the acceleration structure; O(n log n).
  explicit RayCaster(TriangleMesh mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Rays pass through glass where `through_glass` is set.
  RayHits Cast(const RayBundle& rays, double max_range_m, bool through_glass) const;

  /// True if no opaque surface lies between the two points.
  bool IsFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  const Material& material(MaterialId id) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace backsight
