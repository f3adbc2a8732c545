#pragma once

#include <cstddef>

namespace backsight {

/// How many matrices the kernels take at a time; columns have room for as many more.
inline constexpr std::size_t kSymmetricPadding = 8;

/// Eigenvalues of symmetric 3x3 matrices. `matrices`: columns of their elements xx xy xz yy yz zz;
/// `eigenvalues`: three columns, ascending. Without iterating to convergence (after Eberly, A
/// Robust Eigensolver for 3 x 3 Symmetric Matrices, geometrictools.com): the eigenvalue that lies
/// apart from both others is a root of the characteristic polynomial, the others are those of the
/// 2x2 matrix across its eigenvector. Error about 1e-15 of the greatest. The same bits on every
/// instruction set.
void FindEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues);

/// Unit eigenvectors of the smallest eigenvalues, found alike. `directions`: columns of x, y and z;
/// their sign is arbitrary, and so is the direction where the two smallest eigenvalues are equal.
void FindLeastDirections(const double* const* matrices, std::size_t count,
                         double* const* directions);

/// Both, with the same bits, in little more than the time of one.
void FindEigenvaluesAndDirections(const double* const* matrices, std::size_t count,
                                  double* const* eigenvalues, double* const* directions);

}  // namespace backsight
