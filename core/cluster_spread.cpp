#include "core/cluster_spread.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace backsight {

ClusterSpread::ClusterSpread(const PointCluster& cluster) {
  const bool is_counted = cluster.count >= 0.0 && cluster.count < 0x1p32;
  BACKSIGHT_CHECK(is_counted && cluster.count == std::floor(cluster.count),
                  "points of one voxel or cell are counted in 32 bits");
  count_ = static_cast<std::uint32_t>(cluster.count);
  const Eigen::Matrix3d& scatter = cluster.scatter;
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
  const auto narrow = [](double value) { return static_cast<float>(value); };
  factor_ = {narrow(xx), narrow(yx), narrow(yy), narrow(zx), narrow(zy), narrow(zz)};
}

}  // namespace backsight
