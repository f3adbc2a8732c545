#pragma once

#include <vector>

#include "io/survey_project.h"
#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/pair_discovery.h"

namespace backsight {

/// Adds to the record's warnings all that a surveyor should look at before signing: stations and
/// pairs that failed, links that nothing controls or that contradict others, surfaces that were
/// seen through, adjustments that were given up, control. From the record's poses, links,
/// components and georeference, and from the results.
void AddWarnings(const SurveyProject& project, const std::vector<Station>& stations,
                 const PairDiscovery& discovery, const Network& network,
                 const GeoreferencedNetwork& ground, RunRecord* run);

}  // namespace backsight
