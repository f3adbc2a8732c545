#include "core/point_cluster.h"

#include <cmath>

#include "core/error.h"

namespace backsight {

std::uint32_t WholeCount(const PointCluster& cluster) {
  const bool is_counted = cluster.count >= 0.0 && cluster.count < 0x1p32;
  BACKSIGHT_CHECK(is_counted && cluster.count == std::floor(cluster.count),
                  "points of one voxel or cell are counted in 32 bits");
  return static_cast<std::uint32_t>(cluster.count);
}

}  // namespace backsight
