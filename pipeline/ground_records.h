#pragma once

#include <optional>
#include <vector>

#include "io/run_records.h"
#include "pipeline/georeference_network.h"

namespace backsight {

/// How every component was tied to its control, with the residuals of all its survey points.
std::vector<GeoreferenceRecord> MakeGeoreferenceRecords(const SurveyProject& project,
                                                        const GeoreferencedNetwork& ground);

/// A station in the frame of the control, where it has a place there.
std::optional<GroundPose> MakeGroundPose(const GeoreferencedNetwork& ground, std::size_t station);

/// Sightings several times as far from the scanner as its scan reaches.
std::vector<std::string> SightingWarnings(const SurveyProject& project,
                                          const std::vector<Station>& stations);

/// What a surveyor must be told of control: points that are not used or that nothing checks,
/// blunders, contradictions, scale, components without.
std::vector<std::string> GroundWarnings(const SurveyProject& project,
                                        const GeoreferencedNetwork& ground,
                                        const std::vector<GeoreferenceRecord>& records);

}  // namespace backsight
