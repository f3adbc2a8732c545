#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// What report.html says of control and check points: the chain from the coordinate reference
/// system to the network, residuals of every point, and errors at check points. HTML; empty where
/// the project has no control. A non-finite number is an InternalError.
std::string GeoreferenceSection(const RunRecord& run);

}  // namespace backsight
