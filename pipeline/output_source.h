#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"
#include "pipeline/georeference_network.h"
#include "pipeline/moving_points.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/station_pipeline.h"
#include "stages/ingest.h"

namespace backsight {

/// What clouds and maps are written from.
struct OutputSource {
  const IngestOptions& ingest;
  const std::vector<Station>& stations;
  const Network& network;
  const GeoreferencedNetwork& ground;
  const MovingPoints& moving;
};

struct OutputFiles {
  std::vector<OutputRecord> files;
  std::vector<std::string> warnings;
};

}  // namespace backsight
