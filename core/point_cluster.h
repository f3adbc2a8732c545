#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace backsight {

/// Sufficient statistics of a set of points: count, mean and centred scatter. Additive, so that the
/// cluster of any union of voxels is exact over all raw points. Keeping the scatter about the mean
/// (and merging by the parallel-axis rule) avoids the cancellation of E[xx^T] - mm^T at large
/// coordinates (Chan, Golub, LeVeque 1983, doi 10.1080/00031305.1983.10483115).
struct PointCluster {
  double count = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();     ///< metres
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();  ///< sum (x - mean)(x - mean)^T, m^2

  Eigen::Matrix3d Covariance() const { return scatter / count; }

  PointCluster& operator+=(const PointCluster& other) {
    if (other.count == 0.0) return *this;
    const double total = count + other.count;
    const Eigen::Vector3d offset = other.mean - mean;
    scatter += other.scatter + (count * other.count / total) * offset * offset.transpose();
    mean += (other.count / total) * offset;
    count = total;
    return *this;
  }
};

/// The count, which must be whole and below 2^32.
std::uint32_t WholeCount(const PointCluster& cluster);

inline PointCluster operator+(PointCluster a, const PointCluster& b) { return a += b; }

/// The cluster of the same points in another frame.
inline PointCluster Transformed(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                                const PointCluster& cluster) {
  return {cluster.count, rotation * cluster.mean + translation,
          rotation * cluster.scatter * rotation.transpose()};
}

}  // namespace backsight
