#pragma once

#include <string>
#include <vector>

#include "core/execution.h"
#include "io/survey_project.h"
#include "pipeline/output_source.h"

namespace backsight {

/// Writes the clouds the project asks for. Merged ones (default: merged.las in `out_directory`):
/// one file per component of two or more stations; further components get "_component2" and so on
/// in their names, and a cloud that is split over several files "-1", "-2" (WrittenFiles). Then one
/// file per placed station, StationCloudPath. Nothing is written for a network without links.
OutputFiles WriteClouds(const SurveyProject& project, const OutputSource& source,
                        const std::string& out_directory, const ExecutionContext& context);

/// What a cloud of `stations` is made from: `key`, which all outputs share, and its own settings.
ArtifactKey CloudKey(const CloudOutput& output, const std::vector<int>& stations, ArtifactKey key);

}  // namespace backsight
