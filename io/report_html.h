#pragma once

#include <string>

#include "io/report_document.h"

namespace backsight {

/// The text of report.html: one self-contained page without scripts and external resources, the
/// verdict first, that prints on A4. Equal documents give equal bytes. Every text is escaped; a
/// non-finite number is an InternalError naming the field.
std::string ReportHtml(const ReportDocument& document);

}  // namespace backsight
