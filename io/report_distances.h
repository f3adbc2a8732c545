#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// How far apart the surfaces are that several stations measured: definition, histogram with
/// median, 68 % and 95 %, and the pairs that are furthest apart. HTML; a sentence where nothing
/// overlaps. A non-finite number is an InternalError.
std::string DistanceSection(const RunRecord& run);

}  // namespace backsight
