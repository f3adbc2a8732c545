#pragma once

#include <cstdint>
#include <vector>

#include "stages/descriptor_grid.h"

namespace backsight {

/// Columns [begin, end) of a grid.
struct ColumnRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Descriptors sorted by the closest of some pivots, so that like ones lie side by side. Closest as
/// far as the first axes tell.
class DescriptorGroups {
 public:
  /// `pivots`: kGridPadding or a multiple of it, on the grid of `descriptors`. Time
  /// O(descriptors * pivots).
  DescriptorGroups(const DescriptorGrid& descriptors, const DescriptorGrid& pivots);

  /// The descriptors in their new order.
  const DescriptorGrid& grid() const { return grid_; }
  /// Where they were before.
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// The pivot of a descriptor in the new order.
  std::size_t PivotOf(std::size_t place) const { return pivot_[place]; }
  /// 256 columns about those of a pivot, from and to multiples of kGridPadding, as far as there are
  /// so many.
  ColumnRange Around(std::size_t pivot) const;

 private:
  std::vector<std::uint32_t> pivot_;
  std::vector<std::size_t> begins_;  // of each pivot's, and the end of all
  std::vector<std::uint32_t> order_;
  DescriptorGrid grid_;
};

/// Descriptors of the grid evenly chosen, about one in 32, at least kGridPadding and at most 256,
/// like ones side by side; some more than once where the grid has fewer. It must have one.
DescriptorGrid ChoosePivots(const DescriptorGrid& grid);

}  // namespace backsight
