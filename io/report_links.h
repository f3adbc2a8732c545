#pragma once

#include <string>

#include "io/report_document.h"

namespace backsight {

/// Tables of report.html, HTML; a sentence where there is nothing to show. All text is escaped; a
/// non-finite number is an InternalError.

/// Accepted links: what they agree on, and how well they are determined.
std::string LinkTable(const RunRecord& run);
/// Accepted links: how the registration found them.
std::string LinkOriginTable(const RunRecord& run);
/// Pairs, stations, control points and points of scans that were refused or left out, and why.
std::string RejectedSection(const ReportDocument& document);

}  // namespace backsight
