#pragma once

#include <functional>
#include <vector>

#include "core/execution.h"
#include "pipeline/network_pipeline.h"
#include "pipeline/station_pipeline.h"
#include "stages/moving_objects.h"

namespace backsight {

/// What moved while the campaign was scanned, per station; nothing for stations without a place.
struct MovingPoints {
  std::vector<MovingLeaves> stations;  ///< empty where it was not looked for

  const MovingLeaves& Of(std::size_t station) const {
    static const MovingLeaves kNone;
    return station < stations.size() ? stations[station] : kNone;
  }
};

/// Judges every component of the network by itself.
MovingPoints FindMovingPoints(const std::vector<Station>& stations, const Network& network,
                              const MovingObjectOptions& options, const ExecutionContext& context);

/// Whether a point of the station's scan (station frame) is of something that moved. Empty where
/// nothing moved.
std::function<bool(const Eigen::Vector3d&)> IsMovingFunction(const Station& station,
                                                             const MovingLeaves& moving);

/// A usable station at its place: `frame_from_station` leads into a frame that stations share.
PlacedSurface Place(const Station& station, const RigidTransform& frame_from_station);

}  // namespace backsight
