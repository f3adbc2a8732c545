#pragma once

#include "core/random.h"
#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// A tree on the ground at its place: a leaning, bent and tapered stem of irregular section with
/// flaring roots, dead stubs below the crown, branches with twigs, and single leaves in clumps at
/// their ends. Tall trees carry their crowns higher. No two random states give the same tree.
void AddTree(const Tree& tree, const GroundModel& ground, Random& random, TriangleMesh& mesh);

}  // namespace backsight
