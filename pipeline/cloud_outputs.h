#pragma once

#include <string>
#include <vector>

#include "core/execution.h"
#include "io/run_records.h"
#include "io/survey_project.h"
#include "pipeline/georeference_network.h"
#include "pipeline/moving_points.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// What point clouds are written from.
struct CloudSource {
  const IngestOptions& ingest;
  const std::vector<Station>& stations;
  const Network& network;
  const GeoreferencedNetwork& ground;
  const MovingPoints& moving;
};

struct CloudFiles {
  std::vector<OutputRecord> files;
  std::vector<std::string> warnings;
};

/// Writes the clouds the project asks for. Merged ones (default: merged.las in `out_directory`):
/// one file per component of two or more stations; further components get "_component2" and so on
/// in their names, and a cloud that is split over several files "-1", "-2" (WrittenFiles). Then one
/// file per placed station, StationCloudPath. Nothing is written for a network without links.
CloudFiles WriteClouds(const SurveyProject& project, const CloudSource& source,
                       const std::string& out_directory, const ExecutionContext& context);

}  // namespace backsight
