#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace backsight {

/// Descriptors on an integer grid (stages/descriptor_grid.h), axes in pairs of 16 bits each, as the
/// kernels read them. The squared distance of two of them, in grid steps, is D = |a|^2 + |b|^2 -
/// 2 a.b < 2^31.
struct GridView {
  const std::int32_t* pairs;         ///< pair p of descriptor j at pairs[p * stride + j]
  const std::int32_t* half_squares;  ///< |a|^2 / 2, rounded down
  std::size_t size;
  std::size_t stride;  ///< a multiple of kGridPadding, no less than `size`; zeros beyond the last
};

inline constexpr std::size_t kDescriptorBins = 33;
inline constexpr std::size_t kDescriptorPairs = 15;  // three axes are left out
inline constexpr std::size_t kRowBlock = 4;          // rows that the kernels take together
inline constexpr std::size_t kGridPadding = 32;
inline constexpr std::size_t kSeedClasses = 16;

/// For each of kRowBlock rows from `row` on and each class of columns, j modulo kSeedClasses, the
/// closest of the columns [begin, end), multiples of kGridPadding no more than `size`:
/// out[kSeedClasses * r + class] = -h, D / 2 - 1 <= h <= D / 2. The same on all instruction sets.
void FindSeeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
               std::size_t end, std::span<std::int32_t> out);

/// For each of kRowBlock rows from `row` on the closest column, equal ones by number. The columns'
/// size is a multiple of kGridPadding. The same on all instruction sets.
void FindClosest(const GridView& rows, std::size_t row, const GridView& columns,
                 std::span<std::uint32_t, kRowBlock> out);

struct GridPair {
  std::uint32_t row;
  std::uint32_t column;
};

/// Close enough to be looked at: D / 2 < rows[r] of the block's row r, or D / 2 < columns[j] of
/// column j. Limits are no more than 2^30; 0 lets nothing in but what coincides.
struct GridLimits {
  const std::int32_t* rows;     ///< of the block
  const std::int32_t* columns;  ///< of all columns up to the stride
};

/// Pairs of the kRowBlock rows from `row` on with the columns [begin, end), multiples of
/// kGridPadding up to the stride, that are close enough: all that are, and such as miss it by less
/// than 1. `found` has room for kRowBlock (end - begin). Returns their number; their order depends
/// on the instruction set.
std::size_t FindClose(const GridView& rows, std::size_t row, const GridView& columns,
                      std::size_t begin, std::size_t end, const GridLimits& limits,
                      GridPair* found);

/// Sums of squared differences of all bins, in double: of the descriptors themselves,
/// kDescriptorBins floats each. They are summed in eight lanes, so that the bits are the same on
/// all instruction sets.
void ComputeSquaredDistances(const float* rows, const float* columns,
                             std::span<const GridPair> pairs, double* squared);

}  // namespace backsight
