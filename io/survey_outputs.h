#pragma once

#include <vector>

#include "io/strict_yaml.h"
#include "io/survey_project.h"

namespace backsight {

/// The part of a survey project file that says which clouds are wanted; used by ReadSurveyProject.
/// What is wrong joins the document's violations.
OutputSpec ReadOutputs(const YamlValue& map, const std::vector<StationSpec>& stations);

}  // namespace backsight
