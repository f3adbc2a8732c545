#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/point_cluster.h"
#include "core/scatter_factor.h"

namespace backsight {

/// Count and scatter of a cluster whose mean is kept elsewhere, in 28 bytes instead of 80: the
/// scatter's Cholesky factor in single precision. The extent along any axis (the root of the
/// variance, so also a plane's thickness) changes by about 1e-7 of the largest at most.
class ClusterSpread {
 public:
  ClusterSpread() = default;
  /// The count must be whole and below 2^32, the scatter finite; its lower triangle counts.
  explicit ClusterSpread(const PointCluster& cluster);

  /// The cluster, if this is its mean.
  PointCluster About(const Eigen::Vector3d& mean) const {
    return {static_cast<double>(count_), mean,
            ScatterOf({factor_[0], factor_[1], factor_[2], factor_[3], factor_[4], factor_[5]})};
  }

 private:
  std::array<float, 6> factor_{};
  std::uint32_t count_ = 0;
};

}  // namespace backsight
