#pragma once

#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Everything that stands still, as triangles in the world frame. Every object draws its details
/// from a seed of its own, so that adding one leaves the others as they were.
TriangleMesh BuildStaticMesh(const Scene& scene, const GroundModel& ground);

}  // namespace backsight
