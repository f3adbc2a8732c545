#include "stages/simulation/scene_geometry.h"

#include <string>
#include <string_view>
#include <vector>

#include "core/random.h"
#include "stages/simulation/building_geometry.h"
#include "stages/simulation/outdoor_geometry.h"
#include "stages/simulation/room_geometry.h"
#include "stages/simulation/tree_geometry.h"

namespace backsight {
namespace {

Random ObjectRandom(const Scene& scene, std::string_view kind, std::size_t index) {
  return Random(DeriveSeed(scene.seed, std::string(kind) + " " + std::to_string(index)));
}

}  // namespace

TriangleMesh BuildStaticMesh(const Scene& scene, const GroundModel& ground) {
  TriangleMesh mesh;
  const MaterialId asphalt = AddMaterial({0.25, {0.36, 0.36, 0.37}, false}, mesh);
  const MaterialId paving = AddMaterial({0.42, {0.62, 0.6, 0.56}, false}, mesh);
  AddGround(scene.ground, ground, asphalt, paving, mesh);
  for (std::size_t i = 0; i < scene.buildings.size(); ++i) {
    Random random = ObjectRandom(scene, "building", i);
    AddBuilding(scene.buildings[i], ground, random, mesh);
  }
  std::vector<Eigen::Vector2d> keep_clear;
  for (const StationSite& station : scene.stations) keep_clear.push_back(station.position_m);
  for (const ControlSite& site : scene.control) keep_clear.push_back(site.position_m.head<2>());
  for (std::size_t i = 0; i < scene.rooms.size(); ++i) {
    Random random = ObjectRandom(scene, "room", i);
    AddRoom(scene.rooms[i], keep_clear, ground, random, mesh);
  }
  for (std::size_t i = 0; i < scene.trees.size(); ++i) {
    Random random = ObjectRandom(scene, "tree", i);
    AddTree(scene.trees[i], ground, random, mesh);
  }
  for (std::size_t i = 0; i < scene.cars.size(); ++i) {
    Random random = ObjectRandom(scene, "car", i);
    AddCar(scene.cars[i], ground, random, mesh);
  }
  for (const Barrier& barrier : scene.barriers) AddBarrier(barrier, ground, mesh);
  for (const Pole& pole : scene.poles) AddPole(pole, ground, mesh);
  return mesh;
}

}  // namespace backsight
