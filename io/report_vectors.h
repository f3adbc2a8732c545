#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// Plan of a component's control and check points with their residuals as vectors, exaggerated, and
/// its stations, as inline SVG with a legend below. A non-finite number is an InternalError.
std::string ResidualSvg(const RunRecord& run, const GeoreferenceRecord& georeference);

}  // namespace backsight
