#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace backsight {

/// Symmetric 3x3 matrices as columns of their elements xx xy xz yy yz zz, for kernels that take
/// several at a time.
struct SymmetricColumns {
  static constexpr std::size_t kPadding = 8;

  /// Makes room for `n` matrices and the padding behind; keeps what is there.
  void Resize(std::size_t n);
  void Set(std::size_t i, const std::array<double, 6>& matrix) {
    for (std::size_t k = 0; k < matrix.size(); ++k) elements[k][i] = matrix[k];
  }

  std::size_t count = 0;
  std::array<std::vector<double>, 6> elements;
};

using EigenvalueColumns = std::array<std::vector<double>, 3>;

/// Eigenvalues in ascending order, by matrix and padded. They are the roots of the characteristic
/// polynomial: the one that lies apart from both others by Newton's method, the others by what is
/// left of the polynomial. Error about 1e-15 of the largest, of two that are nearly equal up to
/// 1e-8. The same bits on every instruction set.
void FindEigenvalues(const SymmetricColumns& matrices, EigenvalueColumns* eigenvalues);

struct DirectionColumns {
  std::array<std::vector<double>, 3> axes;  ///< unit vectors; their sign is arbitrary
  /// Length of the vector before it was scaled, over the squared trace. What is below 1e-7 is
  /// undefined: the two least eigenvalues are nearly equal.
  std::vector<double> certainty;
};

/// Directions of the smallest eigenvalue, by matrix and padded. Such a direction is orthogonal to
/// the rows of A - lambda I; the longest cross product of two rows is the safest.
void FindLeastDirections(const SymmetricColumns& matrices, DirectionColumns* directions);

}  // namespace backsight
