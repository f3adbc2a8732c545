#pragma once

#include <vector>

#include "io/picture_record.h"
#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"
#include "stages/surface_distances.h"

namespace backsight {

/// Pictures of the main component for the report: density and heights from above, two horizontal
/// and two vertical sections with a detail of each, the place where surfaces lie furthest apart,
/// and where they lie how far apart that several stations measured. Empty if nothing was placed.
/// `distances`: MeasureStationDistances.
std::vector<PictureRecord> DrawReportPictures(const std::vector<Station>& stations,
                                              const Network& network,
                                              const GeoreferencedNetwork& ground,
                                              const SurfaceDistances& distances,
                                              const ExecutionContext& context);

}  // namespace backsight
