#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "stages/simulation/building_geometry.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/outdoor_geometry.h"
#include "stages/simulation/ray_caster.h"
#include "stages/simulation/tree_geometry.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {
namespace {

RayHit CastOne(const RayCaster& caster, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction, bool through_glass = false) {
  RayBundle ray;
  ray.count = 1;
  ray.origins[0] = origin;
  ray.directions[0] = direction.normalized();
  return caster.Cast(ray, 1000.0, through_glass)[0];
}

Eigen::Vector3d RandomDirection(Random& random) { return random.Rotation().col(2); }

/// Exit distance of a ray from inside an axis-aligned box.
double DistanceToBox(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                     const Eigen::Vector3d& half) {
  double nearest = 1e9;
  for (int i = 0; i < 3; ++i) {
    const double wall = direction[i] > 0.0 ? half[i] : -half[i];
    nearest = std::min(nearest, (wall - origin[i]) / direction[i]);
  }
  return nearest;
}

TEST(RayCaster, MatchesAnalyticPlane) {
  TriangleMesh mesh;
  const MaterialId id = AddMaterial({}, mesh);
  // Tilted plane z = 0.25 x - 0.5 y - 2, whose corners are exact in single precision.
  const auto at = [](double x, double y) { return Eigen::Vector3d(x, y, 0.25 * x - 0.5 * y - 2); };
  AddQuad(at(-64, -64), at(64, -64), at(64, 64), at(-64, 64), id, mesh);
  const RayCaster caster(std::move(mesh));
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.25, 0.5, 1.0).normalized();
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d origin(random.Uniform(-5, 5), random.Uniform(-5, 5), 4.0);
    const Eigen::Vector3d direction = RandomDirection(random);
    const double slope = normal.dot(direction);
    const double expected = (-2.0 * normal.z() - normal.dot(origin)) / slope;
    const Eigen::Vector3d point = origin + expected * direction;
    const RayHit hit = CastOne(caster, origin, direction);
    if (expected > 0.0 && point.head<2>().cwiseAbs().maxCoeff() < 63.9) {
      ++hits;
      EXPECT_NEAR(hit.range_m, expected, 1e-9 * std::max(1.0, expected));
      EXPECT_NEAR(hit.cos_incidence, std::abs(slope), 1e-9);
    } else if (expected < 0.0) {
      EXPECT_EQ(hit.range_m, 0.0);
    }
  }
  EXPECT_GT(hits, 150);
}

TEST(RayCaster, MatchesAnalyticBoxFromInsideWithoutLeaks) {
  TriangleMesh mesh;
  const MaterialId id = AddMaterial({}, mesh);
  const Eigen::Vector3d half(4.0, 3.0, 2.5);
  AddBox({}, -half, half, id, mesh);
  const RayCaster caster(std::move(mesh));
  Random random(4);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d origin(random.Uniform(-3, 3), random.Uniform(-2, 2), 0.5);
    const Eigen::Vector3d direction = RandomDirection(random);
    EXPECT_NEAR(CastOne(caster, origin, direction).range_m, DistanceToBox(origin, direction, half),
                1e-9);
  }
}

TEST(RayCaster, WallHidesWhatIsBehind) {
  TriangleMesh mesh;
  const MaterialId wall = AddMaterial({}, mesh);
  const MaterialId behind = AddMaterial({}, mesh);
  AddBox({}, {5.0, -2.0, -2.0}, {5.5, 2.0, 2.0}, wall, mesh);
  AddBox({}, {9.0, -1.0, -1.0}, {10.0, 1.0, 1.0}, behind, mesh);
  const RayCaster caster(std::move(mesh));
  const RayHit hit = CastOne(caster, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX());
  EXPECT_NEAR(hit.range_m, 5.0, 1e-12);
  EXPECT_EQ(hit.material, wall);
  EXPECT_FALSE(caster.IsFree(Eigen::Vector3d::Zero(), {8.9, 0.0, 0.0}));
  EXPECT_TRUE(caster.IsFree(Eigen::Vector3d::Zero(), {4.9, 0.0, 0.0}));
  EXPECT_TRUE(caster.IsFree({7.0, 0.0, 5.0}, {8.0, 0.0, 0.0}));
}

TEST(RayCaster, SeesThroughGlassOnRequest) {
  TriangleMesh mesh;
  const MaterialId glass = AddMaterial({0.1, {0, 0, 0}, true}, mesh);
  const MaterialId wall = AddMaterial({}, mesh);
  AddQuad({3, -1, -1}, {3, 1, -1}, {3, 1, 1}, {3, -1, 1}, glass, mesh);
  AddQuad({6, -1, -1}, {6, 1, -1}, {6, 1, 1}, {6, -1, 1}, wall, mesh);
  const RayCaster caster(std::move(mesh));
  EXPECT_NEAR(CastOne(caster, Eigen::Vector3d::Zero(), {1, 0.1, 0.05}).range_m,
              3.0 * std::sqrt(1.0125), 1e-9);
  EXPECT_NEAR(CastOne(caster, Eigen::Vector3d::Zero(), {1, 0.1, 0.05}, true).range_m,
              6.0 * std::sqrt(1.0125), 1e-9);
}

/// Depths of the facade behind the wall plane, over a grid of rays along the normal.
std::vector<double> FacadeDepths(const Building& building, std::uint64_t seed) {
  TriangleMesh mesh;
  const GroundModel ground({}, seed);
  Random random(seed);
  AddBuilding(building, ground, random, mesh);
  const RayCaster caster(std::move(mesh));
  const double front = -0.5 * building.size_m.y();
  std::vector<double> depths;
  for (double z = 0.5; z < building.wall_height_m - 0.5; z += 0.1) {
    for (double x = -0.49 * building.size_m.x(); x < 0.49 * building.size_m.x(); x += 0.1) {
      const RayHit hit = CastOne(caster, {x + 0.0123, front - 5.0, z + 0.0071}, {0, 1, 0});
      EXPECT_GT(hit.range_m, 0.0) << "a hole in the wall at " << x << ", " << z;
      depths.push_back(hit.range_m - 5.0);
    }
  }
  return depths;
}

TEST(Building, WindowsAreRecessedByTheStatedDepth) {
  Building building;
  building.repeat = true;
  building.window_depth_m = 0.25;
  int wall = 0;
  int recessed = 0;
  for (const double depth : FacadeDepths(building, 1)) {
    if (std::abs(depth) < 1e-5) ++wall;
    if (std::abs(depth - 0.25) < 1e-5) ++recessed;
    EXPECT_LT(depth, 0.3);
  }
  EXPECT_GT(wall, 1000);
  EXPECT_GT(recessed, 300);
}

TEST(Building, FacadesDifferUnlessTheyRepeat) {
  Building building;
  EXPECT_NE(FacadeDepths(building, 1), FacadeDepths(building, 2));
  building.repeat = true;
  EXPECT_EQ(FacadeDepths(building, 1), FacadeDepths(building, 2));
}

TEST(Ground, StripsStandAboveTheSurface) {
  Ground ground;
  ground.slope_deg = {1.0, 0.0};
  ground.undulation_m = 0.1;
  ground.kerbs = {{{0.0, 0.0}, {10.0, 0.0}, 2.0, 0.15}};
  const GroundModel model(ground, 5);
  EXPECT_NEAR(model.Height({5.0, 0.5}) - model.BaseHeight({5.0, 0.5}), 0.15, 1e-12);
  EXPECT_EQ(model.Height({5.0, 1.5}), model.BaseHeight({5.0, 1.5}));
  TriangleMesh mesh;
  const MaterialId id = AddMaterial({}, mesh);
  AddGround(ground, model, id, id, mesh);
  const RayCaster caster(std::move(mesh));
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d place(random.Uniform(-20, 20), random.Uniform(-20, 20));
    const RayHit hit = CastOne(caster, {place.x(), place.y(), 10.0}, {0, 0, -1});
    EXPECT_NEAR(10.0 - hit.range_m, model.Height(place), 0.01);
  }
}

TEST(Outdoor, ObjectsStandOnTheGround) {
  Ground slope;
  slope.slope_deg = {2.0, 1.0};
  const GroundModel ground(slope, 5);
  const Eigen::Vector2d place(12.0, -7.0);
  Random random(8);
  const auto lowest = [&](const auto& add) {
    TriangleMesh mesh;
    add(mesh);
    double low = 1e9;
    for (const auto& vertex : mesh.vertices) low = std::min(low, static_cast<double>(vertex.z()));
    return low - ground.Height(place);
  };
  EXPECT_NEAR(lowest([&](auto& m) {
                AddTree({place, 8.0, 2.0, 100}, ground, random, m);
              }),
              -0.3, 0.05);
  EXPECT_NEAR(lowest([&](auto& m) {
                AddPole({place, 6.0, 0.1, 0.0, true}, ground, m);
              }),
              -0.3, 0.01);
  EXPECT_NEAR(lowest([&](auto& m) { AddCar({place, 30.0, 4.4}, ground, random, m); }), 0.0, 0.05);
  EXPECT_NEAR(lowest([&](auto& m) { AddPerson(place, ground, random, m); }), 0.0, 0.05);
}

}  // namespace
}  // namespace backsight
