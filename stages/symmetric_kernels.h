#pragma once

#include <cstddef>

namespace backsight {

/// How many matrices the kernels take at a time; columns have room for as many more.
inline constexpr std::size_t kSymmetricPadding = 8;

/// Eigenvalues of symmetric 3x3 matrices. `matrices`: columns of their elements xx xy xz yy yz zz;
/// `eigenvalues`: three columns, ascending. They are the roots of the characteristic polynomial:
/// the one that lies apart from both others by Newton's method, the others by what is left of the
/// polynomial. Error about 1e-15 of the largest, of two that are nearly equal up to 1e-8. The same
/// bits on every instruction set.
void FindEigenvalues(const double* const* matrices, std::size_t count, double* const* eigenvalues);

/// Directions of the smallest eigenvalue. Such a direction is orthogonal to the rows of
/// A - lambda I; the longest cross product of two rows is the safest. `directions`: columns of x, y
/// and z of unit vectors of arbitrary sign, and of their certainty: the length of that product over
/// the squared trace. Below 1e-7 the direction is undefined, the two least eigenvalues are nearly
/// equal.
void FindLeastDirections(const double* const* matrices, std::size_t count,
                         double* const* directions);

}  // namespace backsight
