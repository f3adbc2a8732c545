#include "stages/surface_patch.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace backsight {

std::optional<SurfacePatch> PatchOf(const PointCluster& cluster, double edge_m) {
  constexpr double kFewestPoints = 8.0;
  constexpr double kThinness = 0.0625;  // variances
  constexpr double kThickest = 0.1;     // sigma, edges
  constexpr double kBreadth = 0.05;     // variances
  if (cluster.count < kFewestPoints) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(cluster.Covariance());
  const Eigen::Vector3d variance = solver.eigenvalues().cwiseMax(0.0);
  const double sigma = std::sqrt(variance[0]);
  if (variance[0] > kThinness * variance[1] || sigma > kThickest * edge_m) return std::nullopt;
  if (variance[1] < kBreadth * variance[2]) return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return SurfacePatch{cluster.mean,
                      normal.dot(cluster.mean) > 0.0 ? Eigen::Vector3d(-normal) : normal, sigma};
}

std::optional<SurfacePatch> FindPatch(const StationModel& model, const NeighborSearch& search,
                                      std::size_t leaf) {
  constexpr double kRadius = 2.0;  // edges
  PointCluster cluster;
  const double radius_m = kRadius * model.resolution_m();
  for (const auto& neighbor : search.Within(model.leaves[leaf].cluster.mean, radius_m)) {
    cluster += model.leaves[neighbor.index].cluster;
  }
  return PatchOf(cluster, model.resolution_m());
}

}  // namespace backsight
