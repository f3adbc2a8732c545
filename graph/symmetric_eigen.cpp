#include "graph/symmetric_eigen.h"

#include "graph/symmetric_kernels.h"

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
  std::array<std::vector<double>, 3> columns;
  FindLeastDirections(Begins(matrices).data(), matrices.count,
                      Prepare(matrices.count, &columns).data());
  const auto& [x, y, z] = columns;
  std::vector<Eigen::Vector3d> directions(matrices.count);
  for (std::size_t i = 0; i < matrices.count; ++i) directions[i] = {x[i], y[i], z[i]};
  return directions;
}

}  // namespace backsight
