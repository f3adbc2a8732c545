#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads the vertex element of a PLY file (ascii, binary of both byte orders): x y z of any number
/// type, optionally intensity (or scalar_intensity) and red green blue. Other properties and
/// elements, lists too, are skipped. Memory: constant.
std::unique_ptr<ScanReader> OpenPly(const std::string& path);

}  // namespace backsight
