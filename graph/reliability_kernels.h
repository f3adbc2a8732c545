#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace backsight {

/// The columns of PairColumns as the kernels take them; readable 16 floats beyond `rows`, where
/// there are NaN.
struct ColumnView {
  const float* qx;
  const float* qy;
  const float* qz;
  const float* px;
  const float* py;
  const float* pz;
  const float* q_squared;  ///< |q|^2
  const float* p_squared;
  float largest_square;  ///< none of these is larger
  std::size_t rows;
};

/// When two rows are compatible: their lengths differ by less than `limit_m`, and their height
/// differences by less than `height_m` plus `slope` times the length in the source.
struct CompatibilityRule {
  float limit_m = 0.0F;
  float height_m = 0.0F;  ///< infinite where nobody says that z is up
  float slope = 0.0F;
  float inverse_6l2 = 0.0F;  ///< 1 / (6 l^2) of the weight, 1/m^2
};

/// Reliabilities D(a) of the rows a = begin .. begin + out.size() - 1: sum over all rows b of
/// exp(-x^2 / (6 l^2)) where a and b are compatible and share no point. The same bits with every
/// instruction set: sums run in eight lanes, b modulo 8, whatever the width of a vector. Most rows
/// are ruled out by products alone, without differences or roots; fewer where coordinates of
/// kilometres round these. Time O(rows) per row.
void SumReliabilities(const ColumnView& columns, const CompatibilityRule& rule, std::size_t begin,
                      std::span<float> out);

/// The reliabilities of all rows, with the same bits: every pair of rows is looked at once for
/// both, in half the time of one thread. Memory 32 bytes per row.
void SumAllReliabilities(const ColumnView& columns, const CompatibilityRule& rule,
                         std::span<float> out);

/// Rows b in [begin, rows) whose distance from row a may differ by less than `limit_m` between the
/// clouds: all that do, and a few that differ by hardly more. `slack_m` covers the columns'
/// rounding. Ascending; `found` has room for rows + 16. Returns their number.
std::size_t FindSameLength(const ColumnView& columns, std::size_t a, std::size_t begin,
                           float limit_m, float slack_m, std::uint32_t* found);

/// An edge from row i: unit directions to its other end in both clouds.
struct EdgeAxes {
  std::size_t row;
  float qx, qy, qz;
  float px, py, pz;
};

/// Of FindSameLength(columns, edge.row, 0, ...) those whose projections on the edge may differ by
/// less than the limit, too. Gives up, and returns 0, as soon as no more than `bar` can be found.
std::size_t FindAlongEdge(const ColumnView& columns, const EdgeAxes& edge, float limit_m,
                          float slack_m, std::size_t bar, std::uint32_t* found);

}  // namespace backsight
