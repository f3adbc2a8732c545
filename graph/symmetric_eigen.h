#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace backsight {

/// Symmetric 3x3 matrices as padded columns of their elements xx xy xz yy yz zz, so that several
/// are solved at a time.
struct SymmetricColumns {
  void Resize(std::size_t n);
  void Set(std::size_t i, const std::array<double, 6>& matrix) {
    for (std::size_t k = 0; k < matrix.size(); ++k) elements[k][i] = matrix[k];
  }

  std::size_t count = 0;
  std::array<std::vector<double>, 6> elements;
};

/// Eigenvalues in ascending order, by matrix. Padded.
using EigenvalueColumns = std::array<std::vector<double>, 3>;
void FindEigenvalues(const SymmetricColumns& matrices, EigenvalueColumns* eigenvalues);

/// Unit eigenvectors of the smallest eigenvalues; their sign is arbitrary.
std::vector<Eigen::Vector3d> LeastDirections(const SymmetricColumns& matrices);

}  // namespace backsight
