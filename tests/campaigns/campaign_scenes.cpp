#include "tests/campaigns/campaign_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/random.h"
#include "io/scene_file.h"

namespace backsight {
namespace {

Eigen::Vector2d Jitter(Random& random, double reach) {
  const double x = random.Uniform(-reach, reach);
  const double y = random.Uniform(-reach, reach);
  return {x, y};
}

void AddStation(const Eigen::Vector2d& place, Random& random, Scene& scene) {
  StationSite site;
  site.id = fmt::format("S{}", scene.stations.size() + 1);
  site.position_m = place;
  site.height_m = random.Uniform(1.55, 1.8);
  scene.stations.push_back(site);
}

Scene Begin(const std::string& name, std::uint64_t seed, double step_deg, double max_range_m) {
  Scene scene;
  scene.name = name;
  scene.seed = seed;
  scene.format = CampaignFormat::kPly;
  scene.scanner.step_deg = step_deg;
  scene.scanner.max_range_m = max_range_m;
  scene.scanner.min_elevation_deg = -60.0;
  scene.scanner.max_elevation_deg = 85.0;
  scene.scanner.dropout = 0.01;
  return scene;
}

}  // namespace

Scene RepeatedStreet(std::uint64_t seed) {
  Random random(DeriveSeed(seed, "street"));
  Scene scene = Begin("street", seed, 0.35, 70.0);
  const double half_width = random.Uniform(6.5, 8.0);  // from the axis to the facades
  const double block = random.Uniform(22.0, 27.0);
  constexpr int kBlocks = 6;
  const double half_length = 0.5 * kBlocks * block;
  scene.ground.size_m = 2.0 * half_length + 40.0;
  scene.ground.slope_deg = {random.Uniform(-1.0, 1.0), 0.0};
  scene.ground.undulation_m = 0.05;
  const double depth = random.Uniform(10.0, 12.0);
  const double height = random.Uniform(8.5, 11.5);
  const double bay = random.Uniform(2.8, 3.6);
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < kBlocks; ++i) {
      Building house;
      house.center_m = {(i + 0.5) * block - half_length, side * (half_width + 0.5 * depth)};
      house.size_m = {block, depth};
      house.heading_deg = side > 0.0 ? 0.0 : 180.0;
      house.wall_height_m = height;
      house.bay_m = bay;
      house.repeat = true;
      scene.buildings.push_back(house);
    }
    const double kerb = side * (half_width - 1.1);
    scene.ground.kerbs.push_back({{-half_length, kerb}, {half_length, kerb}, 2.2, 0.12});
    const double curb_lane = side * (half_width - 3.3);
    for (double x = -half_length + 3.0; x < half_length - 3.0; x += 5.6) {
      if (random.Uniform() > 0.5) continue;
      const double heading = (random.Index(2) == 0 ? 0.0 : 180.0) + random.Uniform(-3.0, 3.0);
      const double place = x + random.Uniform(-0.5, 0.5);
      const double lane = curb_lane + random.Uniform(-0.15, 0.15);
      scene.cars.push_back({{place, lane}, heading, random.Uniform(3.8, 4.9)});
    }
    const double edge = side * (half_width - 1.9);
    for (double x = -half_length + 4.0; x < half_length - 3.0; x += random.Uniform(9.0, 22.0)) {
      const double tall = random.Uniform(5.0, 9.0);
      scene.trees.push_back({{x, edge}, tall, 0.26 * tall, 1500});
    }
    for (double x = -half_length + 8.0; x < half_length; x += random.Uniform(5.0, 14.0)) {
      Pole sign;
      sign.position_m = {x, edge + side * random.Uniform(-0.1, 0.9)};
      sign.height_m = random.Uniform(1.0, 3.4);
      sign.diameter_m = random.Uniform(0.06, 0.25);
      sign.lamp = false;
      scene.poles.push_back(sign);
    }
  }
  for (double x = -half_length + 0.5 * block; x < half_length; x += block) {
    Pole lamp;
    lamp.position_m = {x, half_width - 1.6};
    lamp.heading_deg = -90.0;
    scene.poles.push_back(lamp);
  }
  Building end;  // closes the street, as a T junction does
  end.center_m = {half_length + 12.0, random.Uniform(-3.0, 3.0)};
  end.size_m = {random.Uniform(24.0, 32.0), 11.0};
  end.heading_deg = 90.0 + random.Uniform(-6.0, 6.0);
  scene.buildings.push_back(end);
  constexpr int kStations = 12;
  const double spacing = (2.0 * half_length - 16.0) / (kStations - 1);
  for (int i = 0; i < kStations; ++i) {
    const double y = (i % 2 == 0 ? -1.2 : 1.2);
    const Eigen::Vector2d place(i * spacing - half_length + 8.0, y);
    // As uneven as a surveyor finds free places, so that stations keep no step with the houses.
    const double along = random.Uniform(-2.2, 2.2);
    AddStation(place + Jitter(random, 0.7) + Eigen::Vector2d(along, 0.0), random, scene);
  }
  scene.people = {12, {-half_length, -half_width}, {half_length, half_width}};
  return scene;
}

Scene SymmetricHall(std::uint64_t seed, bool furnished) {
  Random random(DeriveSeed(seed, "hall"));
  Scene scene = Begin(furnished ? "hall" : "emptyhall", seed, 0.4, 60.0);
  Room hall;
  hall.size_m = {random.Uniform(30.0, 38.0), random.Uniform(15.0, 19.0)};
  hall.heading_deg = random.Uniform(0.0, 360.0);
  hall.height_m = random.Uniform(5.5, 7.5);
  hall.bay_m = random.Uniform(3.6, 4.6);
  hall.pillar_spacing_m = 6.2;
  hall.repeat = true;
  if (furnished) {
    hall.machines = 7 + static_cast<int>(random.Index(5));
    hall.tables = 4 + static_cast<int>(random.Index(4));
    hall.shelves = 5 + static_cast<int>(random.Index(4));
    scene.people.count = 3;
  }
  scene.rooms.push_back(hall);
  scene.ground.size_m = 90.0;
  const double heading = hall.heading_deg * 3.14159265358979 / 180.0;
  const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d across(-along.y(), along.x());
  for (int i = 0; i < 6; ++i) {
    // Off the lines of pillars, which stand at multiples of about 6 m from the middle.
    const double x = (0.33 * (i / 2) - 0.33) * hall.size_m.x();
    const double y = (i % 2 == 0 ? -0.3 : 0.3) * hall.size_m.y();
    AddStation(x * along + y * across + Jitter(random, 1.2), random, scene);
  }
  return scene;
}

Scene Forest(std::uint64_t seed) {
  Random random(DeriveSeed(seed, "forest"));
  Scene scene = Begin("forest", seed, 0.25, 40.0);
  constexpr double kHalf = 28.0;
  scene.ground.size_m = 2.0 * kHalf + 20.0;
  scene.ground.slope_deg = {random.Uniform(-6.0, 6.0), random.Uniform(-6.0, 6.0)};
  scene.ground.undulation_m = random.Uniform(0.9, 1.5);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d grid(9.0 * (i % 4) - 13.5, 10.0 * (i / 4) - 5.0);
    AddStation(grid + Jitter(random, 1.5), random, scene);
  }
  constexpr int kTrees = 150;  // 480 to the hectare
  for (int attempt = 0; attempt < 5000 && scene.trees.size() < kTrees; ++attempt) {
    Tree tree;
    tree.position_m = Jitter(random, kHalf);
    tree.height_m = random.Uniform() < 0.2 ? random.Uniform(3.0, 8.0) : random.Uniform(11.0, 21.0);
    tree.crown_radius_m = std::clamp(0.13 * tree.height_m * random.Uniform(0.8, 1.2), 0.8, 2.6);
    tree.leaves = 1500;
    const auto keeps_clear = [&](const Eigen::Vector2d& place, double distance) {
      return (tree.position_m - place).norm() > distance;
    };
    const bool clear =
        std::all_of(scene.trees.begin(), scene.trees.end(),
                    [&](const Tree& other) { return keeps_clear(other.position_m, 1.7); }) &&
        std::all_of(scene.stations.begin(), scene.stations.end(),
                    [&](const StationSite& site) { return keeps_clear(site.position_m, 1.5); });
    if (clear) scene.trees.push_back(tree);
  }
  return scene;
}

Scene TwoBuildings(std::uint64_t seed) {
  Random random(DeriveSeed(seed, "two buildings"));
  Scene scene = Begin("twobuildings", seed, 0.4, 45.0);
  scene.ground.size_m = 200.0;
  for (const double side : {-1.0, 1.0}) {
    Room hall;
    hall.center_m = {side * random.Uniform(65.0, 75.0), random.Uniform(-10.0, 10.0)};
    hall.size_m = {random.Uniform(17.0, 22.0), random.Uniform(10.0, 13.0)};
    hall.heading_deg = random.Uniform(-40.0, 40.0);
    hall.height_m = random.Uniform(3.6, 4.8);
    hall.bay_m = random.Uniform(3.2, 4.2);
    hall.machines = 2 + static_cast<int>(random.Index(3));
    hall.tables = 4 + static_cast<int>(random.Index(4));
    hall.shelves = 4 + static_cast<int>(random.Index(3));
    scene.rooms.push_back(hall);
    const double heading = hall.heading_deg * 3.14159265358979 / 180.0;
    const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
    const Eigen::Vector2d across(-along.y(), along.x());
    for (int i = 0; i < 4; ++i) {
      const double x = (i % 2 == 0 ? -0.24 : 0.24) * hall.size_m.x();
      const double y = (i / 2 == 0 ? -0.22 : 0.22) * hall.size_m.y();
      AddStation(hall.center_m + x * along + y * across + Jitter(random, 0.8), random, scene);
    }
  }
  return scene;
}

namespace {

/// Where stations stand on the axis of a ring, metres from its lower left corner on.
using StationsAlong = std::vector<double> (*)(const Eigen::Vector2d& axis_size);

Scene Ring(const std::string& name, std::uint64_t seed, StationsAlong stations) {
  Random random(DeriveSeed(seed, "corridor"));
  Scene scene = Begin(name, seed, 0.3, 40.0);
  scene.ground.size_m = 100.0;
  Room ring;
  ring.size_m = {random.Uniform(38.0, 42.0), random.Uniform(24.0, 28.0)};
  const double width = random.Uniform(3.0, 3.6);
  ring.core_m = ring.size_m.array() - 2.0 * width;
  ring.height_m = random.Uniform(2.8, 3.2);
  ring.bay_m = random.Uniform(3.4, 4.4);
  ring.doors = 12;
  ring.tables = 9;
  ring.shelves = 16;
  const Eigen::Vector2d axis = ring.size_m.array() - width;
  // The place at s metres along the axis and the way it runs.
  const auto at = [&](double s, Eigen::Vector2d& along) -> Eigen::Vector2d {
    const double x = axis.x();
    const double y = axis.y();
    const Eigen::Vector2d half = 0.5 * axis;
    if (s < x) return along = {1, 0}, Eigen::Vector2d(s - half.x(), -half.y());
    if (s < x + y) return along = {0, 1}, Eigen::Vector2d(half.x(), s - x - half.y());
    if (s < 2 * x + y) return along = {-1, 0}, Eigen::Vector2d(half.x() - (s - x - y), half.y());
    return along = {0, -1}, Eigen::Vector2d(-half.x(), half.y() - (s - 2 * x - y));
  };
  const std::vector<double> places = stations(axis);
  Eigen::Vector2d along;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double next = i + 1 < places.size() ? places[i + 1] : 2.0 * axis.sum();
    AddStation(at(places[i] + random.Uniform(-0.8, 0.8), along) + Jitter(random, 0.3), random,
               scene);
    // A partition half way to the next station, with a passage at one side.
    const Eigen::Vector2d middle = at(0.5 * (places[i] + next) + random.Uniform(-1.0, 1.0), along);
    const Eigen::Vector2d across(-along.y(), along.x());
    const double side = random.Index(2) == 0 ? -1.0 : 1.0;
    Barrier partition;
    partition.from_m = middle - side * 0.5 * width * across;
    partition.to_m = middle + side * (0.5 * width - 1.8) * across;
    partition.height_m = ring.height_m - 0.1;
    partition.thickness_m = 0.12;
    scene.barriers.push_back(partition);
  }
  scene.rooms.push_back(ring);
  return scene;
}

/// One in each corner, which sees both ways, two between along the long sides, one along the short.
std::vector<double> CornersFirst(const Eigen::Vector2d& axis) {
  std::vector<double> places;
  double corner = 0.0;
  for (const int between : {2, 1, 2, 1}) {
    const double side = between == 2 ? axis.x() : axis.y();
    for (int k = 0; k <= between; ++k) places.push_back(corner + side * k / (between + 1.0));
    corner += side;
  }
  places.front() += 0.8;  // its offset may be negative, and the axis begins at 0
  return places;
}

/// At equal distances, whatever the corners hide.
std::vector<double> EquallySpaced(const Eigen::Vector2d& axis) {
  constexpr int kStations = 10;
  std::vector<double> places;
  for (int i = 0; i < kStations; ++i) places.push_back((i + 0.3) * 2.0 * axis.sum() / kStations);
  return places;
}

}  // namespace

Scene RingCorridor(std::uint64_t seed) { return Ring("corridor", seed, CornersFirst); }
Scene HiddenCorners(std::uint64_t seed) { return Ring("hiddencorners", seed, EquallySpaced); }

Scene OpenField(std::uint64_t seed) {
  Random random(DeriveSeed(seed, "open field"));
  Scene scene = Begin("openfield", seed, 0.35, 35.0);
  scene.ground.size_m = 160.0;
  scene.ground.slope_deg = {random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5)};
  scene.ground.undulation_m = 0.03;
  constexpr double kHalf = 45.0;
  for (int i = 0; i < 14; ++i) {
    Pole pole;
    pole.position_m = Jitter(random, kHalf);
    pole.height_m = random.Uniform(1.0, 4.0);
    pole.diameter_m = 0.1;
    pole.lamp = false;
    scene.poles.push_back(pole);
  }
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d place = Jitter(random, kHalf);
    scene.cars.push_back({place, random.Uniform(0.0, 360.0), random.Uniform(3.8, 4.9)});
    const double tall = random.Uniform(2.0, 4.0);
    scene.trees.push_back({Jitter(random, kHalf), tall, 0.3 * tall, 1000});
  }
  for (int i = 0; i < 6; ++i) {
    const int row = i / 3;
    const Eigen::Vector2d grid(30.0 * (i % 3) - 30.0, 30.0 * row - 15.0);
    AddStation(grid + Jitter(random, 4.0), random, scene);
  }
  return scene;
}

Scene Reseeded(const std::string& scene_file, std::uint64_t seed) {
  Scene scene = ReadScene(scene_file);
  Random random(DeriveSeed(seed, scene.name));
  scene.seed = seed;
  scene.format = CampaignFormat::kPly;
  for (StationSite& site : scene.stations) site.position_m += Jitter(random, 0.5);
  return scene;
}

}  // namespace backsight
