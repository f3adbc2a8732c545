#include "stages/simulation/building_geometry.h"

#include <algorithm>
#include <cmath>

#include "stages/simulation/facade.h"

namespace backsight {
namespace {

constexpr double kFoundation = 0.8;

struct BuildingMaterials {
  FacadeMaterials facade;
  MaterialId roof = 0;
  MaterialId interior = 0;
};

BuildingMaterials DrawMaterials(Random& random, TriangleMesh& mesh) {
  const double red = random.Uniform(0.55, 0.9);
  const double green = red * random.Uniform(0.75, 1.0);
  const double blue = green * random.Uniform(0.65, 1.0);
  const double shade = random.Uniform(0.4, 0.75);
  BuildingMaterials m;
  m.facade.wall = AddMaterial({shade, {red, green, blue}, false}, mesh);
  m.facade.trim = AddMaterial({0.7, {0.85, 0.83, 0.78}, false}, mesh);
  m.facade.frame = AddMaterial({0.6, {0.75, 0.75, 0.75}, false}, mesh);
  m.facade.glass = AddMaterial({0.08, {0.25, 0.35, 0.4}, true}, mesh);
  m.facade.door = AddMaterial({0.3, {0.35 * red, 0.3, 0.2}, false}, mesh);
  m.roof = AddMaterial({0.35, {0.55, 0.28 * red, 0.2}, false}, mesh);
  m.interior = AddMaterial({0.6, {0.7, 0.68, 0.62}, false}, mesh);
  return m;
}

/// Storey heights from the ground up; the ground storey is the tallest.
std::vector<double> Storeys(const Building& building) {
  const double share = building.wall_height_m / (building.storeys + 0.15);
  std::vector<double> heights(static_cast<std::size_t>(building.storeys), share);
  heights.front() = 1.15 * share;
  return heights;
}

/// Rectangle of a level plan in the building's frame.
struct Plan {
  Eigen::Vector2d min;
  Eigen::Vector2d max;
};

void AddLevel(const RigidTransform& frame, const Plan& plan, double z, MaterialId material,
              TriangleMesh& mesh) {
  AddQuad(frame * Eigen::Vector3d(plan.min.x(), plan.min.y(), z),
          frame * Eigen::Vector3d(plan.max.x(), plan.min.y(), z),
          frame * Eigen::Vector3d(plan.max.x(), plan.max.y(), z),
          frame * Eigen::Vector3d(plan.min.x(), plan.max.y(), z), material, mesh);
}

void AddInterior(const Building& building, const std::vector<double>& storeys,
                 const RigidTransform& frame, MaterialId material, TriangleMesh& mesh) {
  const Eigen::Vector2d half = 0.5 * building.size_m;
  const Eigen::Vector2d gap(0.02, 0.02);
  double z = 0.0;
  for (std::size_t i = 0; i + 1 < storeys.size(); ++i) {
    z += storeys[i];
    AddLevel(frame, {gap - half, half - gap}, z, material, mesh);
  }
  const double inset = std::min(3.5, 0.3 * building.size_m.minCoeff());
  AddBox(frame, {inset - half.x(), inset - half.y() + building.arcade_depth_m, -0.1},
         {half.x() - inset, half.y() - inset, building.wall_height_m - 0.3}, material, mesh);
}

void AddFlatRoof(const Building& building, const RigidTransform& frame,
                 const BuildingMaterials& materials, TriangleMesh& mesh) {
  const Eigen::Vector2d half = 0.5 * building.size_m;
  const double height = building.wall_height_m;
  constexpr double kThickness = 0.3;
  constexpr double kParapet = 0.6;
  AddLevel(frame, {-half, half}, height, materials.roof, mesh);
  const auto parapet = [&](double x0, double x1, double y0, double y1) {
    AddBox(frame, {x0, y0, height}, {x1, y1, height + kParapet}, materials.facade.wall, mesh);
  };
  parapet(-half.x(), half.x(), -half.y(), -half.y() + kThickness);
  parapet(-half.x(), half.x(), half.y() - kThickness, half.y());
  parapet(-half.x(), -half.x() + kThickness, -half.y() + kThickness, half.y() - kThickness);
  parapet(half.x() - kThickness, half.x(), -half.y() + kThickness, half.y() - kThickness);
}

/// Gable or hip roof with its ridge along the longer side.
void AddPitchedRoof(const Building& building, const RigidTransform& frame,
                    const BuildingMaterials& materials, TriangleMesh& mesh) {
  const bool turned = building.size_m.y() > building.size_m.x();
  const RigidTransform ridge_frame =
      frame * UprightFrame(Eigen::Vector3d::Zero(), turned ? 90.0 : 0.0);
  const double length = 0.5 * building.size_m.maxCoeff();
  const double width = 0.5 * building.size_m.minCoeff();
  constexpr double kOverhang = 0.45;
  constexpr double kPitch = 0.75;  // rise over run
  const bool hip = building.roof == RoofShape::kHip;
  const double eave = building.wall_height_m - kPitch * kOverhang;
  const double ridge = building.wall_height_m + kPitch * width;
  const double x = length + kOverhang;
  const double y = width + kOverhang;
  const double ridge_x = hip ? length - width : x;
  const auto at = [&](double px, double py, double pz) {
    return ridge_frame * Eigen::Vector3d(px, py, pz);
  };
  for (const double side : {-1.0, 1.0}) {
    AddQuad(at(-x, side * y, eave), at(x, side * y, eave), at(ridge_x, 0.0, ridge),
            at(-ridge_x, 0.0, ridge), materials.roof, mesh);
    if (hip) {
      AddTriangle(at(side * x, -y, eave), at(side * x, y, eave), at(side * ridge_x, 0.0, ridge),
                  materials.roof, mesh);
    } else {
      AddTriangle(at(side * length, -width, building.wall_height_m),
                  at(side * length, width, building.wall_height_m), at(side * length, 0.0, ridge),
                  materials.facade.wall, mesh);
    }
  }
}

void AddChimneys(const Building& building, const RigidTransform& frame, MaterialId material,
                 Random& random, TriangleMesh& mesh) {
  const int count = 1 + static_cast<int>(random.Index(3));
  const double run = 0.5 * building.size_m.minCoeff();
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(-0.35, 0.35) * building.size_m.x();
    const double y = random.Uniform(-0.3, 0.3) * building.size_m.y();
    const double half = random.Uniform(0.25, 0.5);
    const double rise = building.roof == RoofShape::kFlat ? 1.2 : 0.75 * run + 0.8;
    AddBox(frame, {x - half, y - 0.3, building.wall_height_m - 0.2},
           {x + half, y + 0.3, building.wall_height_m + rise}, material, mesh);
  }
}

void AddFacades(const Building& building, const std::vector<double>& storeys,
                const RigidTransform& frame, const BuildingMaterials& materials, Random& random,
                TriangleMesh& mesh) {
  for (int side = 0; side < 4; ++side) {
    const bool along = side % 2 == 0;
    const double width = along ? building.size_m.x() : building.size_m.y();
    const double reach = 0.5 * (along ? building.size_m.y() : building.size_m.x());
    const RigidTransform panel =
        frame * UprightFrame(Eigen::Vector3d::Zero(), 90.0 * side) *
        RigidTransform{Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.5 * width, -reach, 0.0)};
    FacadeSpec spec;
    spec.style = building.style;
    spec.width_m = width;
    spec.storeys_m = storeys;
    spec.foundation_m = kFoundation;
    spec.bay_m = building.bay_m;
    spec.window_depth_m = building.window_depth_m;
    spec.doors = side == 0 ? building.doors : 0;
    spec.repeat = building.repeat;
    spec.arches = side == 0 && building.arcade_depth_m > 0.0;
    AddFacade(spec, materials.facade, panel, random, mesh);
    if (!spec.arches) continue;
    FacadeSpec passage = spec;
    passage.arches = false;
    passage.projections = false;
    passage.storeys_m = {storeys.front()};
    const RigidTransform back =
        panel * RigidTransform{Eigen::Matrix3d::Identity(), {0.0, building.arcade_depth_m, 0.0}};
    AddFacade(passage, materials.facade, back, random, mesh);
  }
}

}  // namespace

void AddBuilding(const Building& building, const GroundModel& ground, Random& random,
                 TriangleMesh& mesh) {
  const BuildingMaterials materials = DrawMaterials(random, mesh);
  const RigidTransform frame = UprightFrame(ground.At(building.center_m), building.heading_deg);
  const std::vector<double> storeys = Storeys(building);
  AddFacades(building, storeys, frame, materials, random, mesh);
  AddInterior(building, storeys, frame, materials.interior, mesh);
  if (building.roof == RoofShape::kFlat) {
    AddFlatRoof(building, frame, materials, mesh);
  } else {
    AddPitchedRoof(building, frame, materials, mesh);
  }
  if (!building.repeat) AddChimneys(building, frame, materials.interior, random, mesh);
}

}  // namespace backsight
