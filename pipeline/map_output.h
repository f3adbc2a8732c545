#pragma once

#include <string>

#include "core/execution.h"
#include "io/survey_project.h"
#include "pipeline/output_source.h"

namespace backsight {

/// The map a run draws: the project's, where it does not say map.ot in `out_directory`.
MapOutput WantedMap(const SurveyProject& project, const std::string& out_directory);

/// Writes an occupancy map for each component of two or more stations: to `map`.path, those of
/// further components beside it (ComponentPath). In `enu` of the project's CRS where control places
/// the component in one, otherwise in the survey frame of the component. Nothing where `map`.path
/// is empty. A map that cannot hold its component is left out with a warning; so are files named
/// that an earlier run left under these names.
OutputFiles WriteMaps(const MapOutput& map, const OutputSource& source,
                      const ExecutionContext& context);

/// What a component's map is made from: `key`, which all outputs share, and its own settings.
ArtifactKey MapKey(const MapOutput& map, int component, ArtifactKey key);

}  // namespace backsight
