#pragma once

#include <string>

#include "io/report_document.h"

namespace backsight {

/// The pictures of these kinds as figures: framed, with ticks, scale bar, legend, title and
/// caption. HTML; empty without any. A non-finite number is an InternalError.
std::string PictureFigures(const ReportDocument& document,
                           std::initializer_list<PictureRecord::Kind> kinds);

}  // namespace backsight
