#include "stages/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

#include "stages/symmetric_kernels.h"

namespace backsight {
namespace {

/// Makes room and returns where the columns begin.
template <std::size_t N>
std::array<double*, N> Prepare(std::size_t count, std::array<std::vector<double>, N>* columns) {
  std::array<double*, N> begins;
  for (std::size_t k = 0; k < N; ++k) {
    (*columns)[k].resize(count + kSymmetricPadding);
    begins[k] = (*columns)[k].data();
  }
  return begins;
}

std::array<const double*, 6> Begins(const SymmetricColumns& matrices) {
  std::array<const double*, 6> begins;
  for (std::size_t k = 0; k < 6; ++k) begins[k] = matrices.elements[k].data();
  return begins;
}

/// Finds a direction even where the two smallest eigenvalues are nearly one.
Eigen::Vector3d IterativeLeastDirection(const SymmetricColumns& matrices, std::size_t i) {
  const auto& [xx, xy, xz, yy, yz, zz] = matrices.elements;
  Eigen::Matrix3d matrix;
  matrix << xx[i], xy[i], xz[i], xy[i], yy[i], yz[i], xz[i], yz[i], zz[i];
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvectors().col(0);
}

}  // namespace

void SymmetricColumns::Resize(std::size_t n) {
  count = n;
  Prepare(n, &elements);
}

void FindEigenvalues(const SymmetricColumns& matrices, EigenvalueColumns* eigenvalues) {
  FindEigenvalues(Begins(matrices).data(), matrices.count,
                  Prepare(matrices.count, eigenvalues).data());
}

std::vector<Eigen::Vector3d> LeastDirections(const SymmetricColumns& matrices) {
  constexpr double kCertain = 1e-7;  // far above the rounding of the cross product, 1e-16
  std::array<std::vector<double>, 4> columns;
  FindLeastDirections(Begins(matrices).data(), matrices.count,
                      Prepare(matrices.count, &columns).data());
  const auto& [x, y, z, certainty] = columns;
  std::vector<Eigen::Vector3d> directions(matrices.count);
  for (std::size_t i = 0; i < matrices.count; ++i) {
    directions[i] = certainty[i] > kCertain ? Eigen::Vector3d(x[i], y[i], z[i])
                                            : IterativeLeastDirection(matrices, i);
  }
  return directions;
}

}  // namespace backsight
