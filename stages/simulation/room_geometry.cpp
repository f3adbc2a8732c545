#include "stages/simulation/room_geometry.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stages/simulation/facade.h"

namespace backsight {
namespace {

struct RoomMaterials {
  FacadeMaterials facade;
  MaterialId ceiling = 0;
  MaterialId metal = 0;
  MaterialId wood = 0;
};

RoomMaterials DrawMaterials(Random& random, TriangleMesh& mesh) {
  const double shade = random.Uniform(0.55, 0.8);
  RoomMaterials m;
  m.facade.wall = AddMaterial({shade, {0.8, 0.79, 0.74}, false}, mesh);
  m.facade.trim = AddMaterial({0.5, {0.6, 0.6, 0.6}, false}, mesh);
  m.facade.frame = AddMaterial({0.6, {0.8, 0.8, 0.8}, false}, mesh);
  m.facade.glass = AddMaterial({0.08, {0.3, 0.4, 0.45}, true}, mesh);
  m.facade.door = AddMaterial({0.3, {0.45, 0.32, 0.2}, false}, mesh);
  m.ceiling = AddMaterial({0.7, {0.88, 0.88, 0.86}, false}, mesh);
  m.metal = AddMaterial({0.35, {0.3, 0.45, 0.4}, false}, mesh);
  m.wood = AddMaterial({0.45, {0.6, 0.45, 0.28}, false}, mesh);
  return m;
}

/// Free places on the floor: circles that do not touch.
class FloorPlan {
 public:
  FloorPlan(const Room& room, const RigidTransform& world_from_room) : room_(room) {
    room_from_world_ = world_from_room.Inverse();
  }
  void KeepClear(const Eigen::Vector2d& world, double radius) {
    Occupy((room_from_world_ * Eigen::Vector3d(world.x(), world.y(), 0.0)).head<2>(), radius);
  }
  void Occupy(const Eigen::Vector2d& place, double radius) { taken_.push_back({place, radius}); }

  /// Finds a place for an object of that radius, room frame; false if it does not fit anywhere.
  bool Place(double radius, Random& random, Eigen::Vector2d& place) {
    const Eigen::Vector2d reach = 0.5 * room_.size_m.array() - radius - 0.15;
    if (reach.minCoeff() <= 0.0) return false;
    for (int attempt = 0; attempt < 200; ++attempt) {
      const double x = random.Uniform(-reach.x(), reach.x());
      const double y = random.Uniform(-reach.y(), reach.y());
      place = {x, y};
      if (Take(place, radius)) return true;
    }
    return false;
  }

  /// Finds a place along the outer wall or the core, with the heading of that wall.
  bool PlaceAtWall(double radius, Random& random, Eigen::Vector2d& place, double& heading_deg) {
    constexpr double kFromWall = 0.45;
    for (int attempt = 0; attempt < 200; ++attempt) {
      const bool core = random.Index(2) == 1;
      const Eigen::Vector2d half = 0.5 * (core ? room_.core_m : room_.size_m);
      const Eigen::Vector2d line = half.array() + (core ? kFromWall : -kFromWall);
      const auto side = static_cast<int>(random.Index(4));
      const int along = side % 2;
      const double end = half[along] - radius;
      const double s = random.Uniform(-1.0, 1.0) * end;
      if (end <= 0.0) continue;
      place[along] = s;
      place[1 - along] = side < 2 ? line[1 - along] : -line[1 - along];
      heading_deg = 90.0 * along;
      if (Take(place, radius)) return true;
    }
    return false;
  }

 private:
  bool Take(const Eigen::Vector2d& place, double radius) {
    const bool is_free = std::all_of(taken_.begin(), taken_.end(), [&](const Circle& c) {
      return (place - c.center).norm() > radius + c.radius;
    });
    if (is_free) Occupy(place, radius);
    return is_free;
  }

  struct Circle {
    Eigen::Vector2d center;
    double radius;
  };
  const Room& room_;
  RigidTransform room_from_world_;
  std::vector<Circle> taken_;
};

void AddMachine(const RigidTransform& frame, const RoomMaterials& materials, Random& random,
                TriangleMesh& mesh) {
  const double length = random.Uniform(1.2, 2.2);
  const double width = random.Uniform(0.7, 1.3);
  const double height = random.Uniform(0.8, 1.4);
  AddBox(frame, {-length / 2, -width / 2, -0.05}, {length / 2, width / 2, 0.15},
         materials.facade.trim, mesh);
  AddBox(frame, {-0.45 * length, -0.45 * width, 0.15}, {0.45 * length, 0.45 * width, height},
         materials.metal, mesh);
  const double column = random.Uniform(0.15, 0.35) * length;
  const double top = height + random.Uniform(0.4, 1.1);
  AddBox(frame, {-0.45 * length, -0.3 * width, height}, {column - 0.45 * length, 0.3 * width, top},
         materials.metal, mesh);
  const double radius = random.Uniform(0.12, 0.3);
  AddTube(frame * Eigen::Vector3d(0.1 * length, 0.0, height),
          frame * Eigen::Vector3d(0.1 * length, 0.0, height + random.Uniform(0.3, 0.9)), radius,
          0.8 * radius, 18, materials.facade.trim, mesh);
  AddBox(frame, {0.3 * length, -0.6 * width, 0.9}, {0.36 * length, -0.45 * width, 1.35},
         materials.facade.frame, mesh);
}

void AddTable(const RigidTransform& frame, const RoomMaterials& materials, Random& random,
              TriangleMesh& mesh) {
  const double half_length = random.Uniform(0.6, 1.0);
  const double half_width = random.Uniform(0.35, 0.5);
  constexpr double kTop = 0.75;
  AddBox(frame, {-half_length, -half_width, kTop - 0.04}, {half_length, half_width, kTop},
         materials.wood, mesh);
  for (const double x : {-half_length + 0.04, half_length - 0.09}) {
    for (const double y : {-half_width + 0.04, half_width - 0.09}) {
      AddBox(frame, {x, y, -0.05}, {x + 0.05, y + 0.05, kTop - 0.04}, materials.metal, mesh);
    }
  }
  const double x = random.Uniform(-0.7, 0.3) * half_length;
  const double tall = random.Uniform(0.15, 0.5);
  AddBox(frame, {x, -0.15, kTop}, {x + 0.3, 0.12, kTop + tall}, materials.facade.trim, mesh);
}

void AddShelf(const RigidTransform& frame, const RoomMaterials& materials, Random& random,
              TriangleMesh& mesh) {
  const double half = random.Uniform(0.7, 1.1);
  constexpr double kDepth = 0.4;
  constexpr double kStep = 0.48;
  const int boards = 4 + static_cast<int>(random.Index(2));
  for (const double x : {-half, half - 0.04}) {
    AddBox(frame, {x, -kDepth / 2, -0.05}, {x + 0.04, kDepth / 2, kStep * boards}, materials.metal,
           mesh);
  }
  for (int i = 0; i < boards; ++i) {
    const double z = 0.1 + kStep * i;
    AddBox(frame, {-half, -kDepth / 2, z}, {half, kDepth / 2, z + 0.03}, materials.wood, mesh);
    double x = -half + 0.1;
    while (x < half - 0.35) {
      const double width = random.Uniform(0.12, 0.32);
      const double tall = random.Uniform(0.1, 0.38);
      if (random.Uniform() < 0.7) {
        AddBox(frame, {x, -0.17, z + 0.03}, {x + width, 0.15, z + 0.03 + tall},
               materials.facade.door, mesh);
      }
      x += width + 0.05;
    }
  }
}

/// The walls of a rectangle about the room's middle, seen from within, or from without (`core`).
void AddWalls(const Room& room, const Eigen::Vector2d& size, bool core, const RigidTransform& frame,
              const RoomMaterials& materials, Random& random, TriangleMesh& mesh) {
  int doors_left = room.doors;
  for (int side = 0; side < 4; ++side) {
    const bool along = side % 2 == 0;
    FacadeSpec spec;
    spec.style = FacadeStyle::kIndustrial;
    spec.width_m = along ? size.x() : size.y();
    spec.storeys_m = {room.height_m};
    spec.bay_m = room.bay_m;
    spec.doors = (doors_left + 3 - side) / (4 - side);
    spec.repeat = room.repeat;
    spec.projections = false;
    doors_left -= spec.doors;
    const double reach = 0.5 * (along ? size.y() : size.x()) * (core ? -1.0 : 1.0);
    const RigidTransform panel = frame * UprightFrame(Eigen::Vector3d::Zero(), 90.0 * side) *
                                 RigidTransform{Eigen::Matrix3d::Identity(),
                                                Eigen::Vector3d(-0.5 * spec.width_m, reach, 0.0)};
    AddFacade(spec, materials.facade, panel, random, mesh);
  }
}

/// What the windows of the core show is a blank block behind them.
void AddCore(const Room& room, const RigidTransform& frame, const RoomMaterials& materials,
             Random& random, TriangleMesh& mesh) {
  AddWalls(room, room.core_m, true, frame, materials, random, mesh);
  const Eigen::Vector2d half = 0.5 * room.core_m.array() - 0.25 * room.core_m.minCoeff();
  AddBox(frame, {-half.x(), -half.y(), -0.1}, {half.x(), half.y(), room.height_m},
         materials.facade.wall, mesh);
}

void AddCeiling(const Room& room, const RigidTransform& frame, const RoomMaterials& materials,
                TriangleMesh& mesh) {
  const Eigen::Vector2d half = 0.5 * room.size_m;
  const double z = room.height_m;
  AddQuad(frame * Eigen::Vector3d(-half.x(), -half.y(), z),
          frame * Eigen::Vector3d(half.x(), -half.y(), z),
          frame * Eigen::Vector3d(half.x(), half.y(), z),
          frame * Eigen::Vector3d(-half.x(), half.y(), z), materials.ceiling, mesh);
  const int beams = std::max(1, static_cast<int>(room.size_m.x() / room.bay_m));
  for (int i = 1; i < beams; ++i) {
    const double x = -half.x() + room.size_m.x() * i / beams;
    AddBox(frame, {x - 0.15, -half.y(), z - 0.4}, {x + 0.15, half.y(), z + 0.1},
           materials.facade.trim, mesh);
  }
}

void AddPillars(const Room& room, const RigidTransform& frame, const RoomMaterials& materials,
                FloorPlan& floor, TriangleMesh& mesh) {
  if (room.pillar_spacing_m <= 0.0) return;
  const Eigen::Vector2i count = (room.size_m / room.pillar_spacing_m).array().floor().cast<int>();
  const double half = 0.5 * room.pillar_size_m;
  for (int i = 1; i < count.x(); ++i) {
    for (int j = 1; j < count.y(); ++j) {
      const double x = room.size_m.x() * (static_cast<double>(i) / count.x() - 0.5);
      const double y = room.size_m.y() * (static_cast<double>(j) / count.y() - 0.5);
      floor.Occupy({x, y}, 1.5 * half);
      if (room.repeat || (i + j) % 2 == 0) {
        AddBox(frame, {x - half, y - half, -0.1}, {x + half, y + half, room.height_m},
               materials.facade.wall, mesh);
      } else {
        AddTube(frame * Eigen::Vector3d(x, y, -0.1), frame * Eigen::Vector3d(x, y, room.height_m),
                half, half, 24, materials.facade.wall, mesh);
      }
      AddBox(frame, {x - 1.3 * half, y - 1.3 * half, room.height_m - 0.55},
             {x + 1.3 * half, y + 1.3 * half, room.height_m - 0.4}, materials.facade.trim, mesh);
    }
  }
}

}  // namespace

void AddRoom(const Room& room, std::span<const Eigen::Vector2d> keep_clear,
             const GroundModel& ground, Random& random, TriangleMesh& mesh) {
  const RoomMaterials materials = DrawMaterials(random, mesh);
  const RigidTransform frame = UprightFrame(ground.At(room.center_m), room.heading_deg);
  AddWalls(room, room.size_m, false, frame, materials, random, mesh);
  const bool ring = !room.core_m.isZero();
  if (ring) AddCore(room, frame, materials, random, mesh);
  AddCeiling(room, frame, materials, mesh);
  FloorPlan floor(room, frame);
  for (const Eigen::Vector2d& place : keep_clear) floor.KeepClear(place, 0.8);
  AddPillars(room, frame, materials, floor, mesh);

  using Furnish = void (*)(const RigidTransform&, const RoomMaterials&, Random&, TriangleMesh&);
  const auto furnish = [&](int count, double radius, Furnish add) {
    for (int i = 0; i < count; ++i) {
      Eigen::Vector2d place;
      double heading = 0.0;
      if (ring) {
        if (!floor.PlaceAtWall(radius, random, place, heading)) continue;
      } else {
        if (!floor.Place(radius, random, place)) continue;
        heading = random.Uniform(0.0, 360.0);
      }
      add(frame * UprightFrame({place.x(), place.y(), 0.0}, heading), materials, random, mesh);
    }
  };
  furnish(room.machines, 1.25, &AddMachine);
  furnish(room.shelves, 1.15, &AddShelf);
  furnish(room.tables, 1.1, &AddTable);
}

}  // namespace backsight
