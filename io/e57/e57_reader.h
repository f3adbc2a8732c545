#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads scan `scan_index` of an E57 file (ASTM E2807): cartesian or spherical coordinates,
/// intensity and colour by the limits the file states. Records marked as invalid count as
/// no_return, as do cells (0, 0, 0) of a scan grid. The pose becomes info().world_from_scan and is
/// not applied. Images, extensions and other scans are passed over. The checksum of every page that
/// is read is verified. Memory: some hundred kilobytes, beside the XML section while opening.
std::unique_ptr<ScanReader> OpenE57(const std::string& path, int scan_index);

}  // namespace backsight
