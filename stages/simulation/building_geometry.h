#pragma once

#include "core/random.h"
#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Adds a building: four facades, roof, chimneys, and plain floors and inner walls behind the
/// windows, so that a pulse through the glass meets something.
void AddBuilding(const Building& building, const GroundModel& ground, Random& random,
                 TriangleMesh& mesh);

}  // namespace backsight
