#pragma once

#include <cstddef>

#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Adds the walking people and the passing cars as the scan number `scan` sees them, of materials
/// marked as moving. They keep clear of the stations, of buildings, trees, poles and cars, and cars
/// of each other; who finds no place is left out.
void AddMovingObjects(const Scene& scene, const GroundModel& ground, std::size_t scan,
                      TriangleMesh& mesh);

}  // namespace backsight
