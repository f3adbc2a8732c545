#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "stages/simulation/building_geometry.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/outdoor_geometry.h"
#include "stages/simulation/ray_caster.h"
#include "stages/simulation/room_geometry.h"
#include "stages/simulation/tree_geometry.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {
namespace {

RayHit CastOne(const RayCaster& caster, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction) {
  RayBundle ray;
  ray.count = 1;
  ray.origins[0] = origin;
  ray.directions[0] = direction.normalized();
  return caster.Cast(ray, 1000.0, false)[0];
}

Eigen::Vector3d PlanDirection(double angle) { return {std::cos(angle), std::sin(angle), 0.0}; }

constexpr int kRays = 72;

/// Bark points at one height that rays from all around hit which aim past `middle` by `aside`.
std::vector<Eigen::Vector3d> BarkPoints(const RayCaster& caster, const Eigen::Vector3d& middle,
                                        double aside) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector3d outward = PlanDirection(2.0 * std::numbers::pi * i / kRays);
    const Eigen::Vector3d side(-outward.y(), outward.x(), 0.0);
    const Eigen::Vector3d from = middle + 3.0 * outward + aside * side;
    const double range = CastOne(caster, from, -outward).range_m;
    if (range > 0.0) points.push_back(from - range * outward);
  }
  return points;
}

Eigen::Vector3d MiddleOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Distances from the stem's middle to its bark at one height. Stems lean, so the middle is sought.
std::vector<double> StemSection(const RayCaster& caster, double height) {
  std::vector<Eigen::Vector3d> all;
  for (double aside = -0.5; aside <= 0.5; aside += 0.02) {
    const auto points = BarkPoints(caster, {0.0, 0.0, height}, aside);
    all.insert(all.end(), points.begin(), points.end());
  }
  const std::vector<Eigen::Vector3d> bark = BarkPoints(caster, MiddleOf(all), 0.0);
  EXPECT_EQ(bark.size(), static_cast<std::size_t>(kRays));
  const Eigen::Vector3d middle = MiddleOf(bark);
  std::vector<double> radii;
  for (const Eigen::Vector3d& point : bark) radii.push_back((point - middle).norm());
  return radii;
}

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(Tree, StemsAreIrregularTaperAndDiffer) {
  const GroundModel ground(Ground{}, 3);
  std::vector<double> first;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Random random(seed);
    TriangleMesh mesh;
    // A tree of 9 m has nothing about its stem below 2 m.
    AddTree({{0.0, 0.0}, 9.0, 1.2, 0}, ground, random, mesh);
    const RayCaster caster(std::move(mesh));
    const std::vector<double> low = StemSection(caster, 1.0);
    const auto [least, most] = std::minmax_element(low.begin(), low.end());
    EXPECT_GT(*least, 0.03);
    EXPECT_LT(*most, 0.3);
    EXPECT_GT(*most - *least, 0.04 * MeanOf(low));
    EXPECT_LT(MeanOf(StemSection(caster, 1.7)), 0.97 * MeanOf(low));
    EXPECT_GT(MeanOf(StemSection(caster, 0.1)), 1.1 * MeanOf(low));
    if (first.empty())
      first = low;
    else
      EXPECT_GT(std::abs(MeanOf(first) - MeanOf(low)), 1e-4);
  }
}

TEST(TriangleMesh, TrianglesWithinHoldAllThatIsNear) {
  TriangleMesh mesh;
  Ground wide;
  wide.size_m = 200.0;
  const GroundModel ground(wide, 3);
  AddGround(wide, ground, AddMaterial({}, mesh), 0, mesh);
  Random random(5);
  for (int i = 0; i < 12; ++i) {
    const double x = random.Uniform(-90.0, 90.0);
    Building house;
    house.center_m = {x, random.Uniform(-90.0, 90.0)};
    AddBuilding(house, ground, random, mesh);
  }
  const Eigen::Vector3d station(4.0, -7.0, 1.7);
  constexpr double kRadius = 35.0;
  TriangleMesh near = TrianglesWithin(mesh, station, kRadius);
  EXPECT_LT(near.triangles.size(), mesh.triangles.size() / 4);
  EXPECT_EQ(near.materials.size(), mesh.materials.size());
  const RayCaster all(std::move(mesh));
  const RayCaster part(std::move(near));
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d direction = random.Rotation().col(0);
    const RayHit expected = CastOne(all, station, direction);
    if (expected.range_m == 0.0 || expected.range_m > kRadius) continue;
    ++hits;
    EXPECT_NEAR(CastOne(part, station, direction).range_m, expected.range_m, 1e-6);
  }
  EXPECT_GT(hits, 1000);
}

TEST(Room, RepeatingOneIsItsOwnHalfTurn) {
  const GroundModel ground(Ground{}, 3);
  Random random(9);
  Room room;
  room.heading_deg = 30.0;
  room.size_m = {31.0, 17.0};
  room.pillar_spacing_m = 6.2;
  room.repeat = true;
  TriangleMesh mesh;
  AddRoom(room, {}, ground, random, mesh);
  const RayCaster caster(std::move(mesh));
  for (int i = 0; i < 2000; ++i) {
    const double x = random.Uniform(-4.0, 4.0);
    const Eigen::Vector3d origin(x, random.Uniform(-4.0, 4.0), 1.7);
    const Eigen::Vector3d direction = random.Rotation().col(0);
    const Eigen::Vector3d turned_origin(-origin.x(), -origin.y(), origin.z());
    const Eigen::Vector3d turned(-direction.x(), -direction.y(), direction.z());
    const double range = CastOne(caster, origin, direction).range_m;
    // Vertices are single precision: edges may part the two by 1e-5 m across.
    const double other = CastOne(caster, turned_origin, turned).range_m;
    const double beside =
        CastOne(caster, turned_origin + Eigen::Vector3d(1e-4, -2e-4, 1e-4), turned).range_m;
    EXPECT_LT(std::min(std::abs(range - other), std::abs(range - beside)), 0.01);
  }
}

TEST(Room, CoreLeavesARingWithFurnitureAlongItsWalls) {
  const GroundModel ground(Ground{}, 3);
  Random random(4);
  Room room;
  room.size_m = {30.0, 20.0};
  room.core_m = {23.0, 13.0};
  room.shelves = 12;
  room.repeat = true;
  TriangleMesh empty;
  Room unfurnished = room;
  unfurnished.shelves = 0;
  AddRoom(unfurnished, {}, ground, random, empty);
  const std::size_t walls = empty.vertices.size();
  const RayCaster caster(std::move(empty));
  // Between windows, whose sills stand at 45 % of the height.
  EXPECT_NEAR(CastOne(caster, {0.0, -8.25, 1.0}, {0, 1, 0}).range_m, 1.75, 1e-4);
  EXPECT_NEAR(CastOne(caster, {0.0, -8.25, 1.0}, {0, -1, 0}).range_m, 1.75, 1e-4);

  TriangleMesh mesh;
  Random same(4);
  AddRoom(room, {}, ground, same, mesh);
  ASSERT_GT(mesh.vertices.size(), walls);
  for (std::size_t i = walls; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector2d place = mesh.vertices[i].head<2>().cast<double>().cwiseAbs();
    EXPECT_TRUE((place.array() < 0.5 * room.size_m.array()).all());
    EXPECT_TRUE((place.array() > 0.5 * room.core_m.array()).any());
  }
}

}  // namespace
}  // namespace backsight
