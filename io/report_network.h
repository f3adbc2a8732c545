#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// What report.html says of the network as a whole: how the adjustment of each component ended, how
/// well triangles of links close, how planes agree that took no part, and named figures. HTML; a
/// non-finite number is an InternalError.
std::string NetworkSection(const RunRecord& run);

}  // namespace backsight
