#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// Tables of report.html, each a <table> element, or a sentence where there is nothing to show. All
/// text is escaped; a non-finite number is an InternalError.
std::string StationTable(const RunRecord& run);
std::string ScanTable(const RunRecord& run);
std::string OutputTable(const RunRecord& run);

}  // namespace backsight
