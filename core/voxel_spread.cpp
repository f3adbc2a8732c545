#include "core/voxel_spread.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace backsight {

VoxelSpread::VoxelSpread(const PointCluster& cluster) {
  const std::uint32_t count = WholeCount(cluster);
  count_ = {static_cast<std::uint16_t>(count), static_cast<std::uint16_t>(count >> 16U)};
  const ScatterFactor factor = FactorOf(cluster.scatter);
  double largest = 0.0;
  for (const double entry : factor) largest = std::max(largest, std::abs(entry));
  int exponent = 0;  // the least of which kMost units reach the largest
  constexpr double kMost = std::numeric_limits<std::int16_t>::max();
  std::frexp(largest / kMost, &exponent);
  if (exponent < -kLargestExponent) return;  // squared, it is nothing
  BACKSIGHT_CHECK(exponent <= kLargestExponent, "a voxel's points lie close together");
  exponent_ = static_cast<std::int16_t>(exponent);
  for (std::size_t i = 0; i < factor.size(); ++i) {
    factor_[i] = static_cast<std::int16_t>(std::lround(std::ldexp(factor[i], -exponent)));
  }
}

}  // namespace backsight
