#pragma once

#include <functional>
#include <string>

#include "io/las_header.h"

namespace backsight {

/// Reads a LAS file from end to end, as any reader does, and throws InputError unless the header's
/// point count fits the file's size to the byte, its bounding box is exactly that of the points,
/// and its legacy counts and counts by return are those of points that are all return 1 of 1.
/// Returns the header with the reference system. Cost: one pass over the file. `between`, called
/// every few thousand points, may throw to give up.
LasHeader VerifyLas(const std::string& path, const std::function<void()>& between = {});

}  // namespace backsight
