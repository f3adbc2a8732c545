#pragma once

#include <Eigen/Core>
#include <span>

#include "core/point_cluster.h"

namespace backsight {

/// Sums clusters that lie near each other, without a division for each. About a point among them,
/// so that little cancels: a scatter keeps 1e-9 of itself where it is a millimetre thick and a
/// metre wide.
class ClusterSum {
 public:
  void Add(const PointCluster& cluster) {
    if (count_ == 0.0) origin_ = cluster.mean;
    const double n = cluster.count;
    const Eigen::Vector3d d = cluster.mean - origin_;
    const Eigen::Vector3d nd = n * d;
    count_ += n;
    first_ += nd;
    xx_ += cluster.scatter(0, 0) + nd.x() * d.x();
    xy_ += cluster.scatter(1, 0) + nd.y() * d.x();
    xz_ += cluster.scatter(2, 0) + nd.z() * d.x();
    yy_ += cluster.scatter(1, 1) + nd.y() * d.y();
    yz_ += cluster.scatter(2, 1) + nd.z() * d.y();
    zz_ += cluster.scatter(2, 2) + nd.z() * d.z();
  }
  /// Of all that was added, at least one cluster.
  PointCluster Sum() const {
    const Eigen::Vector3d offset = first_ / count_;
    PointCluster sum{count_, origin_ + offset, {}};
    const double xy = xy_ - first_.y() * offset.x();
    const double xz = xz_ - first_.z() * offset.x();
    const double yz = yz_ - first_.z() * offset.y();
    sum.scatter << xx_ - first_.x() * offset.x(), xy, xz, xy, yy_ - first_.y() * offset.y(), yz, xz,
        yz, zz_ - first_.z() * offset.z();
    return sum;
  }

 private:
  double count_ = 0.0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();  // sum of n (mean - origin)
  double xx_ = 0.0, xy_ = 0.0, xz_ = 0.0, yy_ = 0.0, yz_ = 0.0, zz_ = 0.0;
};

/// The plane that lies closest to a cluster's points.
struct PlaneFit {
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();  ///< of the covariance, ascending, m^2
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();       ///< unit, its sign arbitrary
};

/// Fits all clusters, several at a time; `fits` is as long. Without `normals` these stay as they
/// are, in half the time.
void FitPlanes(std::span<const PointCluster> clusters, bool normals, std::span<PlaneFit> fits);

}  // namespace backsight
