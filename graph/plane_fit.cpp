#include "graph/plane_fit.h"

#include <algorithm>
#include <array>

#include "graph/symmetric_kernels.h"

namespace backsight {

void FitPlanes(std::span<const PointCluster> clusters, bool normals, std::span<PlaneFit> fits) {
  constexpr std::size_t kMost = kSymmetricPadding;  // at a time
  std::array<std::array<double, 2 * kMost>, 6> elements{};
  std::array<std::array<double, 2 * kMost>, 3> values;
  std::array<std::array<double, 2 * kMost>, 3> directions;
  std::array<const double*, 6> matrices;
  for (std::size_t k = 0; k < 6; ++k) matrices[k] = elements[k].data();
  const auto begins = [](auto& columns) {
    return std::array<double*, 3>{columns[0].data(), columns[1].data(), columns[2].data()};
  };
  for (std::size_t begin = 0; begin < clusters.size(); begin += kMost) {
    const std::size_t count = std::min(kMost, clusters.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Matrix3d covariance = clusters[begin + i].Covariance();
      elements[0][i] = covariance(0, 0);
      elements[1][i] = covariance(1, 0);
      elements[2][i] = covariance(2, 0);
      elements[3][i] = covariance(1, 1);
      elements[4][i] = covariance(2, 1);
      elements[5][i] = covariance(2, 2);
    }
    if (normals) {
      FindEigenvaluesAndDirections(matrices.data(), count, begins(values).data(),
                                   begins(directions).data());
    } else {
      FindEigenvalues(matrices.data(), count, begins(values).data());
    }
    for (std::size_t i = 0; i < count; ++i) {
      PlaneFit& fit = fits[begin + i];
      fit.eigenvalues = {values[0][i], values[1][i], values[2][i]};
      if (normals) fit.normal = {directions[0][i], directions[1][i], directions[2][i]};
    }
  }
}

}  // namespace backsight
