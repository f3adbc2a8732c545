#pragma once

#include <vector>

#include "io/run_records.h"
#include "io/survey_project.h"
#include "pipeline/georeference_network.h"
#include "pipeline/moving_points.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/pair_discovery.h"
#include "stages/surface_distances.h"

namespace backsight {

/// Everything the reports say, gathered from the results: records of scans, poses, links, gates,
/// the verdict and the exit code.
RunRecord SummarizeRun(const SurveyProject& project, const std::vector<Station>& stations,
                       const PairDiscovery& discovery, const Network& network,
                       const GeoreferencedNetwork& ground, const MovingPoints& moving,
                       const SurfaceDistances& distances, const std::vector<OutputRecord>& outputs);

}  // namespace backsight
