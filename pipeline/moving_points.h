#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "pipeline/georeference_network.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/station_pipeline.h"
#include "stages/moving_objects.h"

namespace backsight {

/// What moved while the campaign was scanned, per station; nothing for stations without a place.
struct MovingPoints {
  std::vector<MovingLeaves> stations;  ///< empty where it was not looked for

  std::uint64_t PointsOf(std::size_t station) const {
    return station < stations.size() ? stations[station].points : 0;
  }
};

/// Judges every component of the network by itself.
MovingPoints FindMovingPoints(const std::vector<Station>& stations, const Network& network,
                              const MovingObjectOptions& options, const ExecutionContext& context);

/// Whether a point of the station's scan (station frame) is of something that moved. The function
/// refers to `station`. Empty where nothing moved.
std::function<bool(const Eigen::Vector3d&)> IsMovingFunction(const Station& station,
                                                             const MovingLeaves& moving);

/// The occupancy map of the stations of one component, as bytes (DrawOccupancyMap), in the local
/// frame of the control where it places the component, otherwise in the survey frame.
std::string OccupancyMapOf(int component, const std::vector<Station>& stations,
                           const Network& network, const GeoreferencedNetwork& ground,
                           const MovingPoints& moving, double resolution_m,
                           const ExecutionContext& context);

}  // namespace backsight
