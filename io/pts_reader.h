#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads scan `scan_index` of a PTS file (Leica Cyclone): per scan a line with the number of points
/// and as many lines "x y z [intensity [r g b]]", intensity from -2048 to 2047. PTS knows no pose
/// and no grid. Columns are given, or they and their ranges are checked against the first lines,
/// see GuessXyzLayout, and noted; comments, blank lines and a header line are allowed as in XYZ
/// text. Opening steps once through the whole file, because only that tells how many scans it
/// holds. Damage behind the scan is noted; a line that makes this scan's own count doubtful is an
/// InputError. Memory: constant.
std::unique_ptr<ScanReader> OpenPts(const std::string& path, int scan_index,
                                    const TextColumns& columns = {});

}  // namespace backsight
