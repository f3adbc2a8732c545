#pragma once

#include <functional>
#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads scan `scan_index` of a PTX file: per scan a header (columns, rows, scanner position and
/// axes, 4x4 matrix) and one line "x y z intensity [r g b]" per grid cell, in the scanner's own
/// frame. The matrix becomes info().world_from_scan and is not applied; cells (0, 0, 0) count as
/// no_return. Opening steps once through the whole file, because only that tells how many scans it
/// holds; `between`, called as it goes, may throw to give up. Memory: constant.
std::unique_ptr<ScanReader> OpenPtx(const std::string& path, int scan_index,
                                    const std::function<void()>& between = {});

}  // namespace backsight
