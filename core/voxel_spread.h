#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/archive.h"
#include "core/point_cluster.h"
#include "core/scatter_factor.h"

namespace backsight {

/// Count and scatter of a voxel's points, whose mean is kept elsewhere, in 18 bytes instead of 80:
/// the scatter's Cholesky factor, each entry in 16 bits, in units of the power of two that the
/// largest needs. The extent along any axis (the root of the variance, so also a surface's
/// thickness) changes by some 3e-5 of the largest, 1e-4 at most: 1 um where a surface fills a voxel
/// of 0.1 m. Larger cells are better kept by ClusterSpread.
class VoxelSpread {
 public:
  VoxelSpread() = default;
  /// The count must be whole and below 2^32, the scatter finite; its lower triangle counts.
  explicit VoxelSpread(const PointCluster& cluster);

  double count() const { return count_[0] + 0x1p16 * count_[1]; }
  /// The cluster, if this is its mean.
  PointCluster About(const Eigen::Vector3d& mean) const {
    constexpr std::int64_t kBias = 1023;  // of a double's exponent, which 52 bits follow
    const auto unit = std::bit_cast<double>((kBias + exponent_) << 52);
    return {count(), mean,
            ScatterOf({unit * factor_[0], unit * factor_[1], unit * factor_[2], unit * factor_[3],
                       unit * factor_[4], unit * factor_[5]})};
  }

  template <class Archive>
  friend void Transfer(Archive& archive, VoxelSpread& spread) {
    archive(spread.factor_, spread.exponent_, spread.count_);
    if constexpr (Archive::kReads) {
      if (std::abs(spread.exponent_) > kLargestExponent) throw DamagedArchive();
    }
  }

 private:
  static constexpr int kLargestExponent = 400;  // squares are numbers, too

  std::array<std::int16_t, 6> factor_{};  // in units of 2^exponent_ m
  std::int16_t exponent_ = 0;
  std::array<std::uint16_t, 2> count_{};  // low and high half
};

}  // namespace backsight
