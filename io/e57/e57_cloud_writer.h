#pragma once

#include <map>
#include <memory>

#include "io/cloud_writer.h"
#include "io/e57/e57_writer.h"

namespace backsight {

/// Writes a cloud as an E57 file with one scan per station, by station number. Points are in their
/// station's frame, unlike those of other clouds, and all of a station come before those of the
/// next. A station without a point has no scan.
std::unique_ptr<CloudWriter> CreateE57CloudWriter(E57FileSpec file,
                                                  std::map<int, E57ScanSpec> scans);

}  // namespace backsight
