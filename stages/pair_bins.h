#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace backsight {

/// A block of oriented points as columns, for kernels that take several at a time.
struct OrientedBlock {
  static constexpr std::size_t kSize = 128;
  std::array<float, kSize> x{}, y{}, z{};     ///< metres
  std::array<float, kSize> nx{}, ny{}, nz{};  ///< unit normal
};

/// Bins of the three angles of FPFH for the pairs of one point with a block of others, 0 to 10
/// each, or kNoBin where the pair has no angles.
struct PairBins {
  static constexpr std::int32_t kBins = 11;
  static constexpr std::int32_t kNoBin = 11;
  std::array<std::int32_t, OrientedBlock::kSize> f1{}, f2{}, f3{};
};

/// One oriented point.
struct OrientedPoint {
  float x, y, z;
  float nx, ny, nz;
};

/// The pair features of Rusu 2009 (doi 10.1109/ROBOT.2009.5152473) as PCL takes them, in 11 bins.
/// With d from point p to point q, the source s is that of the two whose normal is the more
/// parallel to d (p if equal), t the other, and d turned to run from s to t: u = n_s, v = (d x u) /
/// |d x u|, w = u x v; f1 = atan2(w n_t, u n_t) over [-pi, pi], f2 = v n_t and f3 = u d / |d| over
/// [-1, 1]. A pair of one place, or with d along u, has no angles. Fills the first `count` entries;
/// float, arc tangent to 1e-5.
void ComputePairBins(const OrientedPoint& point, const OrientedBlock& others, std::size_t count,
                     PairBins* bins);

}  // namespace backsight
