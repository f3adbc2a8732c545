#pragma once

#include <vector>

#include "io/report_html.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// Pictures of the main component for the report: a plan view of all voxels coloured by station,
/// and two vertical cross-sections, where misalignment between stations would show as double walls.
/// Empty if nothing was placed.
std::vector<ReportPicture> DrawReportPictures(const std::vector<Station>& stations,
                                              const Network& network);

}  // namespace backsight
