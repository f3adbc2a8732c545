#pragma once

#include <string>
#include <vector>

#include "io/strict_yaml.h"
#include "io/survey_project.h"

namespace backsight {

/// The parts of a survey project file that describe stations and survey points; used by
/// ReadSurveyProject. What is wrong joins the document's violations.
std::vector<StationSpec> ReadStations(const YamlValue& list);
std::vector<ControlPoint> ReadControl(const YamlValue& list,
                                      const std::vector<StationSpec>& stations);

/// Rejects `value`, whose text is `id`, if no station is called so; names the nearest one.
void RequireStation(const YamlValue& value, const std::string& id,
                    const std::vector<StationSpec>& stations);

}  // namespace backsight
