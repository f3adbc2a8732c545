#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/e57/e57_writer.h"
#include "io/survey_project.h"
#include "pipeline/output_source.h"

namespace backsight {

/// What E57 files say of stations (indices): by station number, 1 is the first of the project. The
/// pose of a scan is enu_from_station where the station is georeferenced, survey_from_station
/// otherwise. GUID and name are those of the scan that was read; where it had none, or another scan
/// of this file has the same GUID, the GUID follows from station id, points and what `output`
/// leaves out of them, and the name is the id.
std::map<int, E57ScanSpec> E57ScansOf(const std::vector<int>& stations, const OutputSource& source,
                                      const CloudOutput& output);

/// The file with these scans, all of one component, which are what `output` selects of them.
E57FileSpec E57FileOf(const CloudOutput& output, const std::map<int, E57ScanSpec>& scans,
                      const GeodeticFrame* frame);

}  // namespace backsight
