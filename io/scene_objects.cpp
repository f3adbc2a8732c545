#include "io/scene_objects.h"

namespace backsight {
namespace {

constexpr double kFarthest = 1000.0;

double Length(const YamlValue& map, const std::string& key, double fallback, double min,
              double max) {
  return ReadReal(map, key, fallback, min, max, "m");
}

double Heading(const YamlValue& map) {
  return ReadReal(map, "heading_deg", 0.0, -360.0, 360.0, "deg");
}

int Count(const YamlValue& map, const std::string& key, int fallback, int max) {
  return map.Optional(key).Integer(fallback, 0, max);
}

Eigen::Vector2d ReadSize(const YamlValue& value, double min, double max) {
  const std::vector<double> v = value.Reals(2, {min, max, "m"});
  return {v[0], v[1]};
}

/// Reads `from_m` and `to_m`, which must differ.
void ReadLine(const YamlValue& map, Eigen::Vector2d& from_m, Eigen::Vector2d& to_m) {
  from_m = ReadPlanPosition(map.Required("from_m"));
  const YamlValue to = map.Required("to_m");
  to_m = ReadPlanPosition(to);
  if (to.present() && map.Has("from_m") && (to_m - from_m).norm() < 0.1) {
    to.Reject("an end at least 0.1 m from from_m");
  }
}

Kerb ReadKerb(const YamlValue& map) {
  Kerb kerb;
  ReadLine(map, kerb.from_m, kerb.to_m);
  kerb.width_m = Length(map, "width_m", kerb.width_m, 0.1, 50.0);
  kerb.height_m = Length(map, "height_m", kerb.height_m, 0.01, 1.0);
  return kerb;
}

}  // namespace

Eigen::Vector2d ReadPlanPosition(const YamlValue& value) {
  const std::vector<double> v = value.Reals(2, {-kFarthest, kFarthest, "m"});
  return {v[0], v[1]};
}

double ReadReal(const YamlValue& map, const std::string& key, double fallback, double min,
                double max, const std::string& unit) {
  return map.Optional(key).Real(fallback, {min, max, unit});
}

Ground ReadGround(const YamlValue& map) {
  Ground ground;
  if (!map.present()) return ground;
  ground.size_m = Length(map, "size_m", ground.size_m, 5.0, kFarthest);
  ground.undulation_m = Length(map, "undulation_m", ground.undulation_m, 0.0, 2.0);
  const YamlValue slope = map.Optional("slope_deg");
  if (slope.present()) {
    const std::vector<double> v = slope.Reals(2, {-20.0, 20.0, "deg"});
    ground.slope_deg = {v[0], v[1]};
  }
  for (const YamlValue& kerb : map.Optional("kerbs").Items()) {
    ground.kerbs.push_back(ReadKerb(kerb));
  }
  return ground;
}

Building ReadBuilding(const YamlValue& map) {
  Building b;
  b.center_m = ReadPlanPosition(map.Required("center_m"));
  b.size_m = ReadSize(map.Required("size_m"), 2.0, 200.0);
  b.heading_deg = Heading(map);
  b.wall_height_m = Length(map, "wall_height_m", b.wall_height_m, 2.0, 100.0);
  b.storeys = map.Optional("storeys").Integer(b.storeys, 1, 40);
  b.style = static_cast<FacadeStyle>(
      map.Optional("style").Choice(0, {"masonry", "modern", "industrial"}));
  b.roof = static_cast<RoofShape>(map.Optional("roof").Choice(1, {"flat", "gable", "hip"}));
  b.bay_m = Length(map, "bay_m", b.bay_m, 1.0, 20.0);
  b.window_depth_m = Length(map, "window_depth_m", b.window_depth_m, 0.02, 1.0);
  const YamlValue arcade = map.Optional("arcade_depth_m");
  b.arcade_depth_m = arcade.Real(b.arcade_depth_m, {0.0, 20.0, "m"});
  if (b.arcade_depth_m > 0.6 * b.size_m.y()) {
    arcade.Reject("at most 0.6 of the building's second size");
  }
  b.doors = Count(map, "doors", b.doors, 20);
  b.repeat = map.Optional("repeat").Flag(b.repeat);
  return b;
}

Room ReadRoom(const YamlValue& map) {
  Room room;
  room.center_m = ReadPlanPosition(map.Required("center_m"));
  room.size_m = ReadSize(map.Required("size_m"), 2.0, 200.0);
  room.heading_deg = Heading(map);
  room.height_m = Length(map, "height_m", room.height_m, 2.0, 40.0);
  room.bay_m = Length(map, "bay_m", room.bay_m, 1.0, 20.0);
  room.pillar_spacing_m = Length(map, "pillar_spacing_m", room.pillar_spacing_m, 0.0, 50.0);
  room.pillar_size_m = Length(map, "pillar_size_m", room.pillar_size_m, 0.1, 3.0);
  room.doors = Count(map, "doors", room.doors, 20);
  room.machines = Count(map, "machines", room.machines, 200);
  room.tables = Count(map, "tables", room.tables, 200);
  room.shelves = Count(map, "shelves", room.shelves, 200);
  room.repeat = map.Optional("repeat").Flag(room.repeat);
  const YamlValue core = map.Optional("core_m");
  if (core.present()) {
    room.core_m = ReadSize(core, 1.0, 200.0);
    if ((room.size_m - room.core_m).minCoeff() < 2.0) core.Reject("2 m less than the room's size");
  }
  return room;
}

Barrier ReadBarrier(const YamlValue& map) {
  Barrier barrier;
  ReadLine(map, barrier.from_m, barrier.to_m);
  barrier.kind = static_cast<BarrierKind>(map.Optional("kind").Choice(0, {"wall", "fence"}));
  barrier.height_m = Length(map, "height_m", barrier.height_m, 0.2, 20.0);
  barrier.thickness_m = Length(map, "thickness_m", barrier.thickness_m, 0.02, 3.0);
  return barrier;
}

Pole ReadPole(const YamlValue& map) {
  Pole pole;
  pole.position_m = ReadPlanPosition(map.Required("position_m"));
  pole.height_m = Length(map, "height_m", pole.height_m, 0.5, 40.0);
  pole.diameter_m = Length(map, "diameter_m", pole.diameter_m, 0.02, 2.0);
  pole.heading_deg = Heading(map);
  pole.lamp = map.Optional("lamp").Flag(pole.lamp);
  return pole;
}

Tree ReadTree(const YamlValue& map) {
  Tree tree;
  tree.position_m = ReadPlanPosition(map.Required("position_m"));
  tree.height_m = Length(map, "height_m", tree.height_m, 1.0, 60.0);
  tree.crown_radius_m = Length(map, "crown_radius_m", tree.crown_radius_m, 0.2, 20.0);
  tree.leaves = Count(map, "leaves", tree.leaves, 200000);
  return tree;
}

Car ReadCar(const YamlValue& map) {
  Car car;
  car.position_m = ReadPlanPosition(map.Required("position_m"));
  car.heading_deg = Heading(map);
  car.length_m = Length(map, "length_m", car.length_m, 2.0, 8.0);
  return car;
}

People ReadPeople(const YamlValue& map) {
  People people;
  const YamlValue count = map.Optional("people");
  if (!count.present()) return people;
  people.count = count.Integer(0, 0, 1000);
  const YamlValue area = map.Required("area_m");
  const std::vector<double> v = area.Reals(4, {-kFarthest, kFarthest, "m"});
  people.min_m = {v[0], v[1]};
  people.max_m = {v[2], v[3]};
  const bool all_zero = people.min_m.isZero() && people.max_m.isZero();
  if (!all_zero && ((people.max_m - people.min_m).array() < 0.5).any()) {
    area.Reject("[x_min, y_min, x_max, y_max] at least 0.5 m wide");
  }
  return people;
}

Traffic ReadTraffic(const YamlValue& map) {
  Traffic traffic;
  traffic.count = map.Required("count").Integer(0, 0, 1000);
  traffic.from_m = ReadPlanPosition(map.Required("from_m"));
  const YamlValue to = map.Required("to_m");
  traffic.to_m = ReadPlanPosition(to);
  if ((traffic.to_m - traffic.from_m).norm() < 1.0) to.Reject("a lane of at least 1 m");
  return traffic;
}

}  // namespace backsight
