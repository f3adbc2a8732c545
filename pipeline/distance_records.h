#pragma once

#include <optional>
#include <vector>

#include "io/distance_records.h"
#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"
#include "stages/surface_distances.h"

namespace backsight {

/// The distances between the surfaces of all placed stations where their clouds are delivered
/// (DeliveredPlace). Pairs name stations by their indices in `stations`.
SurfaceDistances MeasureStationDistances(const std::vector<Station>& stations,
                                         const Network& network, const GeoreferencedNetwork& ground,
                                         const ExecutionContext& context);

/// Their quantiles and histogram; absent where nothing overlaps.
std::optional<DistanceRecord> MakeDistanceRecord(const std::vector<Station>& stations,
                                                 const SurfaceDistances& distances);

}  // namespace backsight
