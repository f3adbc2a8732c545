#pragma once

#include <span>

#include "core/random.h"
#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Adds a room seen from inside: walls with doors and windows, ceiling with beams, pillars, and
/// machines, tables and shelves in places that keep clear of each other and of `keep_clear` (plan
/// positions). Furniture that finds no place is left out.
void AddRoom(const Room& room, std::span<const Eigen::Vector2d> keep_clear,
             const GroundModel& ground, Random& random, TriangleMesh& mesh);

}  // namespace backsight
