#pragma once

#include <string>

#include "io/report_document.h"

namespace backsight {

/// What report.html begins with: project and software, the frame of the coordinates, the verdict
/// with gates and worst figures, the warnings. HTML; a non-finite number is an InternalError.
std::string ReportHead(const ReportDocument& document);

/// The frame that coordinates of a component are in, as a sentence: the CRS with its heights, the
/// control's local grid, or the survey frame. HTML.
std::string FrameSentence(const RunRecord& run);

}  // namespace backsight
