#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

/// Candidate points as columns, for kernels that take several at a time. `count` is a multiple of
/// LeafGrid::kPadding; what fills it up lies far away.
struct CandidateColumns {
  const float *x, *y, *z;
  std::size_t count = 0;
};

struct Coordinates {
  float x, y, z;
};

/// Sums over the points of a neighbourhood, relative to its centre, so that nothing cancels far
/// from the origin.
struct NeighborhoodMoments {
  double x, y, z;
  double xx, xy, xz, yy, yz, zz;
  std::uint32_t count;
};

/// Moments of the candidates whose squared distance from `center`, in float, is below
/// `squared_radius`. Sums are formed in double and in an order that is the same on every
/// instruction set.
NeighborhoodMoments SumMoments(const CandidateColumns& candidates, const Coordinates& center,
                               float squared_radius);

/// Squared distance from `center` to the nearest candidate with a value above `value`; the largest
/// float if there is none. `values` is as long as the columns.
float SquaredDistanceToGreater(const CandidateColumns& candidates, const double* values,
                               const Coordinates& center, double value);

}  // namespace backsight
