#include "graph/rigid_fit.h"

#include <Eigen/SVD>

namespace backsight {

std::optional<RigidTransform> FitRigid(const Correspondences& c, std::span<const double> weights) {
  const auto weight = [&](std::size_t a) { return weights.empty() ? 1.0 : weights[a]; };
  double total = 0.0;
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  int used = 0;
  for (std::size_t a = 0; a < c.size(); ++a) {
    const double w = weight(a);
    if (w <= 0.0) continue;
    ++used;
    total += w;
    source_mean += w * c.source[a];
    target_mean += w * c.target[a];
  }
  if (used < 3) return std::nullopt;
  source_mean /= total;
  target_mean /= total;

  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t a = 0; a < c.size(); ++a) {
    cross += weight(a) * (c.target[a] - target_mean) * (c.source[a] - source_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross);
  if (!(svd.singularValues()[1] > 1e-9 * svd.singularValues()[0])) return std::nullopt;
  RigidTransform fit;
  fit.rotation = NearestRotation(cross);
  fit.translation = target_mean - fit.rotation * source_mean;
  return fit;
}

std::vector<std::uint32_t> RowsWithin(const Correspondences& c, const RigidTransform& transform,
                                      double threshold_m) {
  std::vector<std::uint32_t> rows;
  const double squared = threshold_m * threshold_m;
  for (std::uint32_t a = 0; a < c.size(); ++a) {
    if ((transform * c.source[a] - c.target[a]).squaredNorm() < squared) rows.push_back(a);
  }
  return rows;
}

}  // namespace backsight
