#pragma once

#include "core/execution.h"
#include "stages/station_model.h"

namespace backsight {

/// A station in the middle of a street of houses, trees, parked cars and lamps, simulated with some
/// 10 million points and voxels of 0.1 m. Takes about half a minute.
StationModel MakeStreetStation(const ExecutionContext& context);

}  // namespace backsight
