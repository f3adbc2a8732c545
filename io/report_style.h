#pragma once

#include <string_view>

namespace backsight {

/// The style sheet of report.html, for screens and for A4 paper.
std::string_view ReportStyle();

}  // namespace backsight
