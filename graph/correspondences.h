#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace backsight {

/// What levelled instruments add: both frames have z up but for `max_tilt_rad`, so that the height
/// difference of two points is the same in both clouds.
struct UprightConstraint {
  double max_tilt_rad = 0.0;
  /// Largest difference of height differences over a distance, beyond noise of `noise_m`.
  double Tolerance(double distance_m, double noise_m) const {
    return noise_m + max_tilt_rad * distance_m;
  }
};

/// Whether two vectors, one in each cloud, rise alike; true where nobody says that z is up.
inline bool RiseAlike(const Eigen::Vector3d& in_source, const Eigen::Vector3d& in_target,
                      double noise_m, const std::optional<UprightConstraint>& upright) {
  return !upright ||
         std::abs(in_source.z() - in_target.z()) < upright->Tolerance(in_source.norm(), noise_m);
}

/// Putative point correspondences, row a: source point q_a (to be moved) and target point p_a, each
/// in its own station frame, metres. A key point may take part in several rows; its id tells so.
struct Correspondences {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
  std::vector<std::uint32_t> source_id;
  std::vector<std::uint32_t> target_id;

  std::size_t size() const { return source.size(); }
  void Add(const Eigen::Vector3d& q, const Eigen::Vector3d& p, std::uint32_t q_id,
           std::uint32_t p_id) {
    source.push_back(q), target.push_back(p), source_id.push_back(q_id), target_id.push_back(p_id);
  }
  Correspondences Subset(std::span<const std::uint32_t> rows) const {
    Correspondences subset;
    for (const std::uint32_t a : rows) {
      subset.Add(source[a], target[a], source_id[a], target_id[a]);
    }
    return subset;
  }
};

}  // namespace backsight
