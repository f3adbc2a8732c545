#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads an uncompressed LAS file of version 1.0 to 1.5 and point format 0 to 10 (ASPRS LAS 1.4
/// R15, sections 2.4 to 2.7): x y z = integer * scale + offset in double, intensity and colour
/// where the points have any that is not 0, classification, and GPS time where it is the adjusted
/// standard time (week times lack their week). Values up to 255 in 16 bit fields are taken as 8 bit
/// ones, with a note. Withheld points are deleted ones by the standard: dropped and counted.
/// Synthetic points are kept and counted in a note. LAS knows no scanner pose. Opening reads a
/// sample of the points; a bounding box that is not theirs is noted at the end. Memory: constant.
std::unique_ptr<ScanReader> OpenLas(const std::string& path);

}  // namespace backsight
