#pragma once

#include <cstdint>

#include "io/scene_description.h"

namespace backsight {

/// A town of 5 x 5 irregular blocks with about 250 houses, two of the blocks open squares; 200
/// stations at the crossings, along the streets and in the squares, 20 000 to 40 000 points each.
Scene Town(std::uint64_t seed);

}  // namespace backsight
