#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// The tables of report.html, each a <table> element, or a sentence where there is nothing to show.
/// All text is escaped; a non-finite number is an InternalError.
std::string GateTable(const RunRecord& run);
std::string StationTable(const RunRecord& run);
std::string LinkTable(const RunRecord& run);
std::string ScanTable(const RunRecord& run);
std::string OutputTable(const RunRecord& run);

}  // namespace backsight
