#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// What report.html says of control and check points: the chain from the coordinate reference
/// system to the network, residuals of every point as vectors and in tables, and errors at check
/// points. HTML. A non-finite number is an InternalError.
std::string GeoreferenceSection(const RunRecord& run);

}  // namespace backsight
