#include "core/scatter_factor.h"

#include <algorithm>
#include <cmath>

namespace backsight {

ScatterFactor FactorOf(const Eigen::Matrix3d& scatter) {
  const auto root = [](double value) { return std::sqrt(std::max(value, 0.0)); };
  // Points in a plane, on a line or alone leave pivots that are rounding. No entry may be larger
  // than its row's diagonal allows, whatever it is divided by.
  const auto entry = [](double value, double pivot, double most) {
    return pivot > 0.0 ? std::clamp(value / pivot, -most, most) : 0.0;
  };
  const double xx = root(scatter(0, 0));
  const double yx = entry(scatter(1, 0), xx, root(scatter(1, 1)));
  const double yy = root(scatter(1, 1) - yx * yx);
  const double zx = entry(scatter(2, 0), xx, root(scatter(2, 2)));
  const double left = root(scatter(2, 2) - zx * zx);
  const double zy = entry(scatter(2, 1) - zx * yx, yy, left);
  const double zz = root(left * left - zy * zy);
  return {xx, yx, yy, zx, zy, zz};
}

}  // namespace backsight
