#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads PCD 0.5 to 0.7 (ascii, binary, binary_compressed): fields x y z, optionally intensity and
/// rgb or rgba (packed); other fields are skipped. VIEWPOINT becomes info().world_from_scan and is
/// not applied. Memory: constant, but for binary_compressed, whose columns must be unpacked whole.
std::unique_ptr<ScanReader> OpenPcd(const std::string& path);

}  // namespace backsight
