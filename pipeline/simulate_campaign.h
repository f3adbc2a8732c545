#pragma once

#include <string>

#include "core/execution.h"

namespace backsight {

/// Simulates the campaign of a scene file (see ReadScene) and writes to `directory`, which is made
/// if need be:
///   scans/ID.ptx          one scan per station, station frame; the header states no pose. Or .ply,
///                         or .las in steps of 0.1 mm
///   truth.csv             true survey_from_station, columns as in poses.csv
///   control.csv           targets: surveyed coordinates and what each station measured
///   NAME.yaml             survey project file, ready for `backsight run`
/// Equal scenes give equal bytes for any number of threads. At most four stations are in
/// memory at a time, about 60 bytes a ray each.
/// Throws InputError for a faulty scene file or an unwritable directory.
void SimulateCampaign(const std::string& scene_path, const std::string& directory,
                      const ExecutionContext& execution);

}  // namespace backsight
