#pragma once

#include "core/random.h"
#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// What stands in streets and courtyards; each object stands on the ground at its place.
void AddPole(const Pole& pole, const GroundModel& ground, TriangleMesh& mesh);
void AddCar(const Car& car, const GroundModel& ground, Random& random, TriangleMesh& mesh);
void AddBarrier(const Barrier& barrier, const GroundModel& ground, TriangleMesh& mesh);
/// A walking person of random height and stride.
void AddPerson(const Eigen::Vector2d& place, const GroundModel& ground, Random& random,
               TriangleMesh& mesh);

}  // namespace backsight
