#include "stages/surface_patch.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/plane_fit.h"

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

std::optional<SurfacePatch> FindPatch(const StationModel& model, const CloudIndex& index,
                                      std::size_t leaf) {
  constexpr double kRadius = 2.0;  // edges
  ClusterSum sum;
  const double radius_m = kRadius * model.resolution_m();
  index.voxels.VisitWithin(
      model.leaves.means(), model.leaves.Mean(leaf), radius_m,
      [&](std::uint32_t near, double) { sum.Add(model.leaves.Cluster(near)); });
  return PatchOf(sum.Sum(), model.resolution_m());
}

}  // namespace backsight
