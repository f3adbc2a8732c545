#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/point_cluster.h"

namespace backsight {

/// Count and scatter of a cluster whose mean is kept elsewhere, in 28 bytes instead of 80. The
/// scatter is kept by its Cholesky factor (Golub and Van Loan, Matrix Computations, section 4.2) in
/// single precision: it stays positive semidefinite, and the extent along any axis (the root of
/// the variance, so also a plane's thickness) changes by about 1e-7 of the largest at most.
class ClusterSpread {
 public:
  ClusterSpread() = default;
  /// The count must be whole and below 2^32, the scatter finite; its lower triangle counts.
  explicit ClusterSpread(const PointCluster& cluster);

  double count() const { return count_; }
  /// The cluster, if this is its mean.
  PointCluster About(const Eigen::Vector3d& mean) const;

  template <class Archive>
  friend void Transfer(Archive& archive, ClusterSpread& spread) {
    archive(spread.factor_, spread.count_);
  }

 private:
  std::array<float, 6> factor_{};  // lower triangle by rows: xx, yx yy, zx zy zz; metres
  std::uint32_t count_ = 0;
};

inline PointCluster ClusterSpread::About(const Eigen::Vector3d& mean) const {
  const double xx = factor_[0], yx = factor_[1], yy = factor_[2];
  const double zx = factor_[3], zy = factor_[4], zz = factor_[5];
  PointCluster cluster{static_cast<double>(count_), mean, {}};
  Eigen::Matrix3d& scatter = cluster.scatter;
  scatter(0, 0) = xx * xx;
  scatter(0, 1) = scatter(1, 0) = xx * yx;
  scatter(0, 2) = scatter(2, 0) = xx * zx;
  scatter(1, 1) = yx * yx + yy * yy;
  scatter(1, 2) = scatter(2, 1) = yx * zx + yy * zy;
  scatter(2, 2) = zx * zx + zy * zy + zz * zz;
  return cluster;
}

}  // namespace backsight
