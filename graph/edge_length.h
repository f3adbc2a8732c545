#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace backsight {

/// Whether both edges are longer than `limit_m`, and their lengths differ by less than that. With
/// squared lengths A and B, (sqrt A - sqrt B)^2 (sqrt A + sqrt B)^2 = (A - B)^2, and (sqrt A + sqrt
/// B)^2 is at least A + B + 2 min(A, B), hardly more than that where they are alike: roots are
/// rarely taken.
inline bool AreOneLength(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double limit_m) {
  constexpr double kRounding = 1e-12;
  const double a2 = a.squaredNorm();
  const double b2 = b.squaredNorm();
  const double limit2 = limit_m * limit_m;
  if (std::min(a2, b2) <= limit2) return false;
  const double at_least = (a2 + b2 + 2.0 * std::min(a2, b2)) * (1.0 - kRounding);
  if ((a2 - b2) * (a2 - b2) < limit2 * at_least) return true;
  return std::abs(std::sqrt(a2) - std::sqrt(b2)) < limit_m;
}

}  // namespace backsight
