#pragma once

#include <Eigen/Core>
#include <array>

namespace backsight {

/// Cholesky factor of a scatter matrix (Golub and Van Loan, Matrix Computations, section 4.2): the
/// lower triangle by rows, xx, yx yy, zx zy zz, in the root of the scatter's unit. However its
/// entries are rounded, what they multiply to is positive semidefinite.
using ScatterFactor = std::array<double, 6>;

/// The scatter must be finite; its lower triangle counts. What rounding has made negative counts as
/// nothing.
ScatterFactor FactorOf(const Eigen::Matrix3d& scatter);

inline Eigen::Matrix3d ScatterOf(const ScatterFactor& factor) {
  const auto [xx, yx, yy, zx, zy, zz] = factor;
  Eigen::Matrix3d scatter;
  scatter(0, 0) = xx * xx;
  scatter(0, 1) = scatter(1, 0) = xx * yx;
  scatter(0, 2) = scatter(2, 0) = xx * zx;
  scatter(1, 1) = yx * yx + yy * yy;
  scatter(1, 2) = scatter(2, 1) = yx * zx + yy * zy;
  scatter(2, 2) = zx * zx + zy * zy + zz * zz;
  return scatter;
}

}  // namespace backsight
