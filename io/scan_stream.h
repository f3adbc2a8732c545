#pragma once

#include <cstddef>
#include <functional>

#include "core/execution.h"
#include "core/point_chunk.h"
#include "io/scan_reader.h"

namespace backsight {

/// Passes a scan's chunks through `slots` (>= 1) places of the caller's, numbered from 0: `work`
/// gets them on all threads, side by side, and `take` in their order, one after another. `points`
/// hold until `take` returns. What is thrown is what reading in turn would throw first: damage is
/// told after the chunks before it have been taken. Memory: two chunks and their text per slot.
void StreamScan(ScanReader& reader, std::size_t slots, const ExecutionContext& context,
                const std::function<void(std::size_t slot, const PointChunk& points)>& work,
                const std::function<void(std::size_t slot, const PointChunk& points)>& take);

}  // namespace backsight
