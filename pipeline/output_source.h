#pragma once

#include <string>
#include <vector>

#include "io/artifact_store.h"
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
  const ArtifactStore& store;
  ArtifactKey key;  ///< what all of them depend on
};

struct OutputFiles {
  std::vector<OutputRecord> files;
  std::vector<std::string> warnings;

  void Add(OutputFiles more) {
    files.insert(files.end(), more.files.begin(), more.files.end());
    warnings.insert(warnings.end(), more.warnings.begin(), more.warnings.end());
  }
};

}  // namespace backsight
