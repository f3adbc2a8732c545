#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// A picture for the report: a residual plot, a cross-section.
struct ReportPicture {
  std::string title;
  std::string caption;
  std::vector<std::uint8_t> png;  ///< bytes of a PNG file (EncodePng)
};

/// The text of report.html: one self-contained page without scripts and external resources, the
/// verdict first. Equal runs give equal bytes. Every text is escaped; a non-finite number is an
/// InternalError naming the field.
std::string ReportHtml(const RunRecord& run, const std::vector<ReportPicture>& pictures);

}  // namespace backsight
