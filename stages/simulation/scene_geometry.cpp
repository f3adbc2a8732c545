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

bool IsInside(const Building& building, const Eigen::Vector2d& place, double margin_m) {
  const RigidTransform frame =
      UprightFrame({building.center_m.x(), building.center_m.y(), 0.0}, building.heading_deg);
  const Eigen::Vector3d local = frame.Inverse() * Eigen::Vector3d(place.x(), place.y(), 0.0);
  return ((local.head<2>().cwiseAbs() - 0.5 * building.size_m).array() < margin_m).all();
}

bool IsWalkable(const Scene& scene, const Eigen::Vector2d& place) {
  const auto clear = [&](const Eigen::Vector2d& other, double radius) {
    return (place - other).norm() > radius;
  };
  for (const Building& b : scene.buildings) {
    if (IsInside(b, place, 0.5)) return false;
  }
  for (const Car& car : scene.cars) {
    if (!clear(car.position_m, 0.6 * car.length_m)) return false;
  }
  for (const Tree& tree : scene.trees) {
    if (!clear(tree.position_m, 0.7)) return false;
  }
  for (const Pole& pole : scene.poles) {
    if (!clear(pole.position_m, 0.6)) return false;
  }
  for (const StationSite& station : scene.stations) {
    if (!clear(station.position_m, 1.2)) return false;
  }
  return true;
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

void AddPeople(const Scene& scene, const GroundModel& ground, std::size_t scan,
               TriangleMesh& mesh) {
  Random random = ObjectRandom(scene, "people in scan", scan);
  for (int i = 0; i < scene.people.count; ++i) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      const double x = random.Uniform(scene.people.min_m.x(), scene.people.max_m.x());
      const double y = random.Uniform(scene.people.min_m.y(), scene.people.max_m.y());
      if (!IsWalkable(scene, {x, y})) continue;
      AddPerson({x, y}, ground, random, mesh);
      break;
    }
  }
}

}  // namespace backsight
