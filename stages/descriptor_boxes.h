#pragma once

#include <cstddef>
#include <cstdint>

#include "core/cache_line_vector.h"
#include "stages/descriptor_kernels.h"

namespace backsight {

/// Bounding boxes of panels of columns, along the first axes and the rest: they rule out whole
/// panels for a block of rows.
class DescriptorBoxes {
 public:
  explicit DescriptorBoxes(const GridView& columns);

  /// Takes over the largest of the columns' limits, GridLimits::columns, of the panels [begin,
  /// end). Limits that have fallen since only let in more.
  void SetLimits(const std::int32_t* limits, std::size_t begin, std::size_t end);

  /// Panels of [begin, end) that may hold a column close enough to a row of the block from `row`
  /// on, whose limits are at most `row_limit`, or by the panel's own limit; ascending, to `near`,
  /// which has room for end - begin and kMostLanes more. `begin` is a multiple of kMostLanes.
  /// Returns their number. The same on all instruction sets.
  std::size_t FindNear(const GridView& rows, std::size_t row, std::int32_t row_limit,
                       std::size_t begin, std::size_t end, std::uint32_t* near) const;

 private:
  // Coordinate c of panel p at [(p / kMostLanes * 2 kFirstPairs + c) * kMostLanes +
  // p % kMostLanes].
  CacheLineVector<std::int32_t> lowest_, highest_;
  CacheLineVector<std::int32_t> limits_;  // of each panel
};

}  // namespace backsight
