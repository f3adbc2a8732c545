#include "stages/simulation/moving_geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/random.h"
#include "stages/simulation/outdoor_geometry.h"

namespace backsight {
namespace {

constexpr int kAttempts = 100;

Random MovingRandom(const Scene& scene, const std::string& kind, std::size_t scan) {
  return Random(DeriveSeed(scene.seed, kind + " in scan " + std::to_string(scan)));
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

/// Whether a passing car meets no building, thing or station.
bool IsDrivable(const Scene& scene, const Car& car) {
  const auto clear = [&](const Eigen::Vector2d& other, double radius) {
    return (car.position_m - other).norm() > 0.6 * car.length_m + radius;
  };
  return std::none_of(scene.buildings.begin(), scene.buildings.end(),
                      [&](const Building& b) { return IsInside(b, car.position_m, 1.2); }) &&
         std::all_of(scene.cars.begin(), scene.cars.end(),
                     [&](const Car& c) { return clear(c.position_m, 0.6 * c.length_m); }) &&
         std::all_of(scene.trees.begin(), scene.trees.end(),
                     [&](const Tree& t) { return clear(t.position_m, 0.3); }) &&
         std::all_of(scene.poles.begin(), scene.poles.end(),
                     [&](const Pole& p) { return clear(p.position_m, 0.1); }) &&
         std::all_of(scene.stations.begin(), scene.stations.end(),
                     [&](const StationSite& s) { return clear(s.position_m, 0.5); });
}

/// Joins the passing cars to the scene's.
void PlaceTraffic(Random& random, Scene* scene) {
  for (const Traffic& lane : scene->traffic) {
    const Eigen::Vector2d along = lane.to_m - lane.from_m;
    Car car;
    car.heading_deg = std::atan2(along.y(), along.x()) * 180.0 / std::numbers::pi;
    for (int i = 0; i < lane.count; ++i) {
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        car.position_m = lane.from_m + random.Uniform(0.0, 1.0) * along;
        if (!IsDrivable(*scene, car)) continue;
        scene->cars.push_back(car);
        break;
      }
    }
  }
}

/// `scene` holds the passing cars among its cars.
void AddPeople(const Scene& scene, const GroundModel& ground, Random& random, TriangleMesh& mesh) {
  for (int i = 0; i < scene.people.count; ++i) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const double x = random.Uniform(scene.people.min_m.x(), scene.people.max_m.x());
      const double y = random.Uniform(scene.people.min_m.y(), scene.people.max_m.y());
      if (!IsWalkable(scene, {x, y})) continue;
      AddPerson({x, y}, ground, random, mesh);
      break;
    }
  }
}

}  // namespace

void AddMovingObjects(const Scene& scene, const GroundModel& ground, std::size_t scan,
                      TriangleMesh& mesh) {
  const std::size_t still = mesh.materials.size();
  Scene busy = scene;
  Random traffic = MovingRandom(scene, "traffic", scan);
  PlaceTraffic(traffic, &busy);
  for (std::size_t i = scene.cars.size(); i < busy.cars.size(); ++i) {
    AddCar(busy.cars[i], ground, traffic, mesh);
  }
  Random people = MovingRandom(scene, "people", scan);
  AddPeople(busy, ground, people, mesh);
  for (std::size_t i = still; i < mesh.materials.size(); ++i) mesh.materials[i].moving = true;
}

}  // namespace backsight
