#include "stages/simulation/outdoor_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace backsight {
namespace {

void AddFence(const Barrier& barrier, const GroundModel& ground, MaterialId material,
              TriangleMesh& mesh) {
  const Eigen::Vector2d along = barrier.to_m - barrier.from_m;
  constexpr double kSlatSpacing = 0.16;
  constexpr int kSlatsPerPost = 15;
  const double heading = std::atan2(along.y(), along.x()) * 180.0 / std::numbers::pi;
  const int slats = std::max(1, static_cast<int>(along.norm() / kSlatSpacing));
  for (int i = 0; i <= slats; ++i) {
    const Eigen::Vector2d place = barrier.from_m + along * i / slats;
    const RigidTransform frame = UprightFrame(ground.At(place), heading);
    const bool post = i % kSlatsPerPost == 0;
    const double half = post ? 0.06 : 0.02;
    AddBox(frame, {-half, -half, post ? -0.3 : 0.08}, {half, half, barrier.height_m}, material,
           mesh);
  }
  const int spans = std::max(1, slats / kSlatsPerPost);
  for (int i = 0; i < spans; ++i) {
    const Eigen::Vector2d from = barrier.from_m + along * i / spans;
    const Eigen::Vector2d to = barrier.from_m + along * (i + 1) / spans;
    for (const double share : {0.2, 0.85}) {
      AddTube(ground.At(from, share * barrier.height_m), ground.At(to, share * barrier.height_m),
              0.03, 0.03, 6, material, mesh);
    }
  }
}

}  // namespace

void AddPole(const Pole& pole, const GroundModel& ground, TriangleMesh& mesh) {
  const MaterialId metal = AddMaterial({0.4, {0.4, 0.42, 0.42}, false}, mesh);
  const RigidTransform frame = UprightFrame(ground.At(pole.position_m), pole.heading_deg);
  const double radius = 0.5 * pole.diameter_m;
  const auto tube = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double ra, double rb) {
    AddTube(frame * a, frame * b, ra, rb, 16, metal, mesh);
  };
  tube({0, 0, -0.3}, {0, 0, 0.9}, 1.3 * radius, 1.3 * radius);
  tube({0, 0, 0.9}, {0, 0, pole.height_m}, radius, 0.7 * radius);
  if (!pole.lamp) return;
  tube({0, 0, pole.height_m - 0.05}, {1.2, 0, pole.height_m + 0.25}, 0.04, 0.04);
  AddBox(frame, {0.9, -0.15, pole.height_m + 0.2}, {1.6, 0.15, pole.height_m + 0.34}, metal, mesh);
}

void AddCar(const Car& car, const GroundModel& ground, Random& random, TriangleMesh& mesh) {
  const double red = random.Uniform(0.1, 0.9);
  const double green = random.Uniform(0.1, 0.9);
  const double blue = random.Uniform(0.1, 0.9);
  const MaterialId paint = AddMaterial({0.35, {red, green, blue}, false}, mesh);
  // Tinted panes send almost nothing back; a transparent cabin would show an empty shell.
  const MaterialId pane = AddMaterial({0.04, {0.1, 0.1, 0.12}, false}, mesh);
  const MaterialId rubber = AddMaterial({0.08, {0.1, 0.1, 0.1}, false}, mesh);
  const RigidTransform frame = UprightFrame(ground.At(car.position_m), car.heading_deg);
  const double length = car.length_m;
  const double half = 0.5 * length;
  const double roof = random.Uniform(1.38, 1.65);
  const std::vector<Eigen::Vector2d> body = {
      {-half + 0.1, 0.3},   {half - 0.15, 0.25},  {half, 0.42},
      {half - 0.02, 0.62},  {half - 0.2, 0.78},   {0.2 * length, 0.92},
      {-half + 0.25, 0.97}, {-half + 0.03, 0.86}, {-half, 0.55}};
  AddPrism(frame, body, 0.88, 0.08, paint, mesh);
  const std::vector<Eigen::Vector2d> cabin = {{-half + 0.2, 0.9},
                                              {0.22 * length, 0.9},
                                              {0.06 * length, roof - 0.05},
                                              {-0.05 * length, roof - 0.01},
                                              {-0.3 * length, roof - 0.03}};
  AddPrism(frame, cabin, 0.76, 0.14, pane, mesh);
  AddBox(frame, {-0.27 * length, -0.55, roof - 0.05}, {0.04 * length, 0.55, roof}, paint, mesh);
  for (const double x : {-0.31 * length, 0.31 * length}) {
    for (const double y : {-0.86, 0.66}) {
      AddTube(frame * Eigen::Vector3d(x, y, 0.31), frame * Eigen::Vector3d(x, y + 0.2, 0.31), 0.32,
              0.32, 18, rubber, mesh);
    }
  }
}

void AddBarrier(const Barrier& barrier, const GroundModel& ground, TriangleMesh& mesh) {
  const MaterialId material =
      AddMaterial(barrier.kind == BarrierKind::kWall ? Material{0.5, {0.6, 0.55, 0.5}, false}
                                                     : Material{0.35, {0.3, 0.3, 0.3}, false},
                  mesh);
  if (barrier.kind == BarrierKind::kFence) return AddFence(barrier, ground, material, mesh);
  const Eigen::Vector2d along = barrier.to_m - barrier.from_m;
  const double heading = std::atan2(along.y(), along.x()) * 180.0 / std::numbers::pi;
  const double half = 0.5 * barrier.thickness_m;
  const RigidTransform frame = UprightFrame(ground.At(barrier.from_m), heading);
  const double length = along.norm();
  AddBox(frame, {0.0, -half, -0.5}, {length, half, barrier.height_m}, material, mesh);
  AddBox(frame, {-0.04, -half - 0.05, barrier.height_m - 0.02},
         {length + 0.04, half + 0.05, barrier.height_m + 0.08}, material, mesh);
}

void AddPerson(const Eigen::Vector2d& place, const GroundModel& ground, Random& random,
               TriangleMesh& mesh) {
  const double red = random.Uniform(0.1, 0.8);
  const double blue = random.Uniform(0.1, 0.8);
  const MaterialId cloth = AddMaterial({0.35, {red, 0.3, blue}, false}, mesh);
  const MaterialId skin = AddMaterial({0.5, {0.8, 0.65, 0.55}, false}, mesh);
  const double height = random.Uniform(1.55, 1.92);
  const double stride = random.Uniform(0.05, 0.32);
  const RigidTransform frame = UprightFrame(ground.At(place), random.Uniform(0.0, 360.0));
  const auto at = [&](double x, double y, double z) {
    return frame * Eigen::Vector3d(x, y, z * height);
  };
  for (const double side : {-1.0, 1.0}) {
    AddTube(at(side * stride, 0.1 * side, 0.0), at(0.0, 0.09 * side, 0.5), 0.06, 0.09, 10, cloth,
            mesh);
    AddTube(at(-side * stride * 0.8, 0.27 * side, 0.44), at(0.0, 0.22 * side, 0.81), 0.04, 0.055, 8,
            cloth, mesh);
  }
  AddTube(at(0, 0, 0.47), at(0, 0, 0.66), 0.15, 0.17, 12, cloth, mesh);
  AddTube(at(0, 0, 0.66), at(0, 0, 0.83), 0.17, 0.19, 12, cloth, mesh);
  AddTube(at(0, 0, 0.83), at(0, 0, 0.88), 0.07, 0.06, 10, skin, mesh);
  AddEllipsoid(at(0, 0, 0.935), {0.1, 0.1, 0.07 * height}, skin, mesh);
}

}  // namespace backsight
