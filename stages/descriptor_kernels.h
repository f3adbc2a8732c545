#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace backsight {

inline constexpr std::size_t kDescriptorPairs = 16;
inline constexpr std::size_t kFirstPairs = 4;
inline constexpr std::size_t kFirstAxes = 2 * kFirstPairs - 1;  // and the rest
inline constexpr std::size_t kRowBlock = 4;  // rows that the kernels take together
inline constexpr std::size_t kGridPadding = 32;
inline constexpr std::size_t kMostLanes = 16;  // of the longest vector
inline constexpr std::size_t kSeedClasses = kMostLanes;

/// Where pair p of descriptor j is: descriptors lie in panels of kGridPadding.
constexpr std::size_t PlaceOnGrid(std::size_t p, std::size_t j) {
  return (j / kGridPadding * kDescriptorPairs + p) * kGridPadding + j % kGridPadding;
}

/// Descriptors on an integer grid (stages/descriptor_grid.h), axes in pairs of 16 bits each, as the
/// kernels read them. The high half of pair kFirstPairs - 1 is no axis but the rest, the residual
/// norm: at least the length of the coordinates along the axes of later pairs. The squared distance
/// of two of them, in grid steps, is D = |a|^2 + |b|^2 - 2 a.b < 2^31.
struct GridView {
  const std::int32_t* pairs;         ///< pair p of descriptor j at pairs[PlaceOnGrid(p, j)]
  const std::int32_t* half_squares;  ///< |a|^2 / 2 without the rest, rounded down
  std::size_t size;
  std::size_t stride;  ///< a multiple of kGridPadding, no less than `size`; zeros beyond the last
};

/// One half of a pair: coordinate c is the low half of pair c / 2 where c is even, else the high
/// one.
inline std::int32_t CoordinateOf(const GridView& grid, std::size_t c, std::size_t j) {
  const std::int32_t pair = grid.pairs[PlaceOnGrid(c / 2, j)];
  return c % 2 == 0 ? static_cast<std::int16_t>(pair) : pair >> 16;
}

/// For each of kRowBlock rows from `row` on the k-th largest, k <= kSeedClasses, of what the
/// columns of each class, j modulo kSeedClasses, have as their largest -h, D / 2 - 1 <= h <= D / 2:
/// k columns of [begin, end), multiples of kGridPadding no more than `size`, are no farther. The
/// same on all instruction sets.
void FindSeeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
               std::size_t end, std::size_t k, std::span<std::int32_t, kRowBlock> kth);

/// For each of kRowBlock rows from `row` on the closest column as far as the first axes and the
/// rest tell, equal ones by number. The columns' size is a multiple of kGridPadding. The same on
/// all instruction sets.
void FindClosest(const GridView& rows, std::size_t row, const GridView& columns,
                 std::span<std::uint32_t, kRowBlock> out);

/// Close enough to be looked at: D / 2 < rows[r] of the block's row r, or D / 2 < columns[j] of
/// column j. Limits are no more than 2^30; 0 lets nothing in but what coincides.
struct GridLimits {
  const std::int32_t* rows;     ///< of the block
  const std::int32_t* columns;  ///< of all columns up to the stride
};

/// Columns are in panels of kGridPadding, of which at most so many are looked at together. The
/// kernels write whole vectors.
inline constexpr std::size_t kMostPanels = 32;
inline constexpr std::size_t kFoundRoom = kRowBlock * kMostPanels * kGridPadding + kMostLanes;

/// Pairs that were found, room for kFoundRoom.
struct GridPairs {
  std::uint32_t* rows;
  std::uint32_t* columns;
};

/// How many pairs were found, and how many columns were compared along all axes.
struct CloseCount {
  std::size_t pairs;
  std::size_t columns;
};

/// Pairs of the kRowBlock rows from `row` on with the columns of these panels that are close
/// enough: all that are, and such as miss it by less than 1; their order depends on the instruction
/// set. With `first_axes` the first axes and the rest rule out what they can before all others are
/// multiplied, which changes nothing but the time.
CloseCount FindClose(const GridView& rows, std::size_t row, const GridView& columns,
                     std::span<const std::uint32_t> panels, const GridLimits& limits,
                     bool first_axes, const GridPairs& found);

}  // namespace backsight
