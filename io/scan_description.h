#pragma once

#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// What `backsight info SCAN` prints, for people: one aligned line "key  value" per fact, from the
/// header alone. Ends with a line end.
std::string DescribeScan(const ScanInfo& info);

}  // namespace backsight
