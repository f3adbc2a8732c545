#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

/// One oriented point: metres, unit normal.
struct OrientedPoint {
  float x, y, z;
  float nx, ny, nz;
};

/// Oriented points as columns, for kernels that take several at a time. `count` is a multiple of
/// LeafGrid::kPadding.
struct OrientedColumns {
  const float *x, *y, *z;
  const float *nx, *ny, *nz;
  std::size_t count = 0;
};

/// How often each bin of the three angles of FPFH was met, and by how many points.
struct PairHistogram {
  static constexpr std::size_t kBins = 11;
  static constexpr std::size_t kBlocks = 3;  ///< one per angle
  std::uint32_t counts[kBlocks * kBins] = {};
  std::uint32_t neighbors = 0;  ///< points within the radius, with angles or without
};

/// Histogram of the pair features of Rusu 2009 (doi 10.1109/ROBOT.2009.5152473), as PCL takes them,
/// of `point` with those of `others` whose squared distance is below `squared_radius`.
///
/// With d from point p to point q, the source s is that of the two whose normal is the more
/// parallel to d (p if equal), t the other, and d turned to run from s to t: u = n_s, v = (d x u) /
/// |d x u|, w = u x v; f1 = atan2(w n_t, u n_t) over [-pi, pi], f2 = v n_t and f3 = u d / |d| over
/// [-1, 1]. A pair of one place, or with d along u, has no angles: it is a neighbour in no bin.
///
/// No angle is ever formed: whether it lies beyond a bin's edge is a comparison of products, which
/// takes neither root nor quotient. All operations are rounded alike on every instruction set, so
/// the counts do not depend on the machine. Some 2 ns a pair with AVX-512.
PairHistogram CountPairs(const OrientedPoint& point, const OrientedColumns& others,
                         float squared_radius);

}  // namespace backsight
