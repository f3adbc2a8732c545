#pragma once

#include <string>

#include "io/survey_project.h"
#include "pipeline/survey_options.h"

namespace backsight {

/// Reads a project file and fills the options; beyond what ReadSurveyProject finds it refuses
/// control that cannot place anything (FindControlFaults) and sightings beyond the range up to
/// which scans are used, which are in another unit or of another point. One InputError for all.
SurveyProject ReadCheckedProject(const std::string& path, SurveyOptions* options);

}  // namespace backsight
