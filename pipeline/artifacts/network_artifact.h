#pragma once

#include <string>
#include <string_view>

#include "pipeline/moving_points.h"
#include "pipeline/network_pipeline.h"

namespace backsight {

/// A network and what moved in it, as bytes and back. The readers throw DamagedArchive.
std::string NetworkBytes(const Network& network);
Network NetworkFrom(std::string_view bytes);
std::string MovingPointsBytes(const MovingPoints& moving);
MovingPoints MovingPointsFrom(std::string_view bytes);

}  // namespace backsight
