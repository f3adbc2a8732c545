#include "stages/simulation/opening.h"

#include <cmath>
#include <numbers>

namespace backsight {
namespace {

/// Draws in the panel frame.
class Panel {
 public:
  Panel(const RigidTransform& world_from_panel, TriangleMesh& mesh)
      : world_from_panel_(world_from_panel), mesh_(mesh) {}

  void Quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& d, MaterialId material) {
    AddQuad(world_from_panel_ * a, world_from_panel_ * b, world_from_panel_ * c,
            world_from_panel_ * d, material, mesh_);
  }
  /// A rectangle parallel to the wall at depth y.
  void Face(const WallRectangle& r, double y, MaterialId material) {
    Quad({r.left, y, r.bottom}, {r.right, y, r.bottom}, {r.right, y, r.top}, {r.left, y, r.top},
         material);
  }
  void Box(double left, double right, double front, double back, double bottom, double top,
           MaterialId material) {
    AddBox(world_from_panel_, {left, front, bottom}, {right, back, top}, material, mesh_);
  }

 private:
  const RigidTransform& world_from_panel_;
  TriangleMesh& mesh_;
};

/// Four trapezoids between the cell and the hole, so that no vertex lies on another one's edge.
void AddWallAround(const WallRectangle& cell, const WallRectangle& hole, MaterialId wall,
                   Panel& panel) {
  const std::array<Eigen::Vector3d, 4> outer = {{{cell.left, 0, cell.bottom},
                                                 {cell.right, 0, cell.bottom},
                                                 {cell.right, 0, cell.top},
                                                 {cell.left, 0, cell.top}}};
  const std::array<Eigen::Vector3d, 4> inner = {{{hole.left, 0, hole.bottom},
                                                 {hole.right, 0, hole.bottom},
                                                 {hole.right, 0, hole.top},
                                                 {hole.left, 0, hole.top}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    panel.Quad(outer[i], outer[j], inner[j], inner[i], wall);
  }
}

void AddReveals(const WallRectangle& hole, double depth, MaterialId wall, Panel& panel) {
  const std::array<Eigen::Vector2d, 4> corners = {{{hole.left, hole.bottom},
                                                   {hole.right, hole.bottom},
                                                   {hole.right, hole.top},
                                                   {hole.left, hole.top}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& a = corners[i];
    const Eigen::Vector2d& b = corners[(i + 1) % 4];
    panel.Quad({a.x(), 0, a.y()}, {b.x(), 0, b.y()}, {b.x(), depth, b.y()}, {a.x(), depth, a.y()},
               wall);
  }
}

void AddWindow(const Opening& opening, const FacadeMaterials& materials, Panel& panel) {
  const WallRectangle& hole = opening.hole;
  const double y = opening.depth_m;
  panel.Face(hole, y, materials.glass);
  constexpr double kBar = 0.06;
  const auto bar = [&](double left, double right, double bottom, double top) {
    panel.Box(left, right, y - 0.04, y + 0.03, bottom, top, materials.frame);
  };
  bar(hole.left, hole.right, hole.bottom, hole.bottom + kBar);
  bar(hole.left, hole.right, hole.top - kBar, hole.top);
  for (int i = 0; i <= opening.panes; ++i) {
    const double middle = hole.left + kBar / 2 + (hole.width() - kBar) * i / opening.panes;
    bar(middle - kBar / 2, middle + kBar / 2, hole.bottom, hole.top);
  }
  const double transom = hole.bottom + 0.7 * hole.height();
  bar(hole.left, hole.right, transom - kBar / 2, transom + kBar / 2);
  if (opening.sill) {
    panel.Box(hole.left - 0.1, hole.right + 0.1, -0.07, 0.02, hole.bottom - 0.08, hole.bottom,
              materials.trim);
    panel.Box(hole.left - 0.12, hole.right + 0.12, -0.05, 0.02, hole.top, hole.top + 0.14,
              materials.trim);
  }
  if (opening.shutters) {
    const double leaf = 0.5 * hole.width();
    panel.Box(hole.left - leaf, hole.left - 0.02, -0.05, -0.01, hole.bottom, hole.top,
              materials.door);
    panel.Box(hole.right + 0.02, hole.right + leaf, -0.05, -0.01, hole.bottom, hole.top,
              materials.door);
  }
}

void AddBalcony(const WallRectangle& hole, const FacadeMaterials& materials, Panel& panel) {
  constexpr double kReach = 1.1;
  const double left = hole.left - 0.4;
  const double right = hole.right + 0.4;
  const double floor = hole.bottom - 0.1;
  panel.Box(left, right, -kReach, 0.05, floor - 0.16, floor, materials.trim);
  const auto rail = [&](double a, double b, double front, double back, double low, double high) {
    panel.Box(a, b, front, back, floor + low, floor + high, materials.frame);
  };
  rail(left, right, -kReach, -kReach + 0.05, 0.95, 1.0);
  rail(left, left + 0.05, -kReach, 0.0, 0.95, 1.0);
  rail(right - 0.05, right, -kReach, 0.0, 0.95, 1.0);
  const int posts = std::max(2, static_cast<int>((right - left) / 0.14));
  for (int i = 0; i <= posts; ++i) {
    const double x = left + (right - left - 0.03) * i / posts;
    rail(x, x + 0.03, -kReach, -kReach + 0.03, 0.0, 0.95);
  }
}

void AddDoor(const Opening& opening, const FacadeMaterials& materials, Panel& panel) {
  const WallRectangle& hole = opening.hole;
  const double y = opening.depth_m;
  panel.Face(hole, y, materials.door);
  panel.Box(hole.left, hole.left + 0.08, y - 0.05, y + 0.02, hole.bottom, hole.top,
            materials.frame);
  panel.Box(hole.right - 0.08, hole.right, y - 0.05, y + 0.02, hole.bottom, hole.top,
            materials.frame);
  panel.Box(hole.left, hole.right, y - 0.05, y + 0.02, hole.top - 0.08, hole.top, materials.frame);
  for (const double low : {0.1, 0.55}) {
    panel.Box(hole.left + 0.2, hole.right - 0.2, y - 0.03, y + 0.01,
              hole.bottom + low * hole.height(), hole.bottom + (low + 0.32) * hole.height(),
              materials.door);
  }
  panel.Box(hole.right - 0.22, hole.right - 0.12, y - 0.09, y, hole.bottom + 1.0,
            hole.bottom + 1.05, materials.frame);
}

/// A round arch through a wall as thick as the pillars are deep.
void AddArch(const WallRectangle& cell, const Opening& opening, MaterialId wall, Panel& panel) {
  constexpr int kSteps = 12;
  const WallRectangle& hole = opening.hole;
  const double radius = 0.5 * hole.width();
  const double middle = hole.left + radius;
  const double spring = hole.top - radius;
  const auto at = [&](int i) -> Eigen::Vector2d {
    const double angle = std::numbers::pi * (1.0 - static_cast<double>(i) / kSteps);
    return {middle + radius * std::cos(angle), spring + radius * std::sin(angle)};
  };
  for (const double y : {0.0, opening.depth_m}) {
    panel.Face({cell.left, hole.left, cell.bottom, cell.top}, y, wall);
    panel.Face({hole.right, cell.right, cell.bottom, cell.top}, y, wall);
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Vector2d a = at(i);
      const Eigen::Vector2d b = at(i + 1);
      panel.Quad({a.x(), y, a.y()}, {b.x(), y, b.y()}, {b.x(), y, cell.top}, {a.x(), y, cell.top},
                 wall);
    }
  }
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector2d a = at(i);
    const Eigen::Vector2d b = at(i + 1);
    panel.Quad({a.x(), 0, a.y()}, {b.x(), 0, b.y()}, {b.x(), opening.depth_m, b.y()},
               {a.x(), opening.depth_m, a.y()}, wall);
  }
  for (const double x : {hole.left, hole.right}) {
    panel.Quad({x, 0, cell.bottom}, {x, opening.depth_m, cell.bottom}, {x, opening.depth_m, spring},
               {x, 0, spring}, wall);
  }
}

}  // namespace

void AddWallCell(const WallRectangle& cell, const Opening& opening,
                 const FacadeMaterials& materials, const RigidTransform& world_from_panel,
                 TriangleMesh& mesh) {
  Panel panel(world_from_panel, mesh);
  switch (opening.kind) {
    case OpeningKind::kNone:
      panel.Face(cell, 0.0, materials.wall);
      return;
    case OpeningKind::kArch:
      AddArch(cell, opening, materials.wall, panel);
      return;
    case OpeningKind::kBlind:
      AddWallAround(cell, opening.hole, materials.wall, panel);
      AddReveals(opening.hole, opening.depth_m, materials.wall, panel);
      panel.Face(opening.hole, opening.depth_m, materials.wall);
      return;
    case OpeningKind::kWindow:
    case OpeningKind::kDoor:
      AddWallAround(cell, opening.hole, materials.wall, panel);
      AddReveals(opening.hole, opening.depth_m + 0.1, materials.wall, panel);
      if (opening.kind == OpeningKind::kDoor) return AddDoor(opening, materials, panel);
      AddWindow(opening, materials, panel);
      if (opening.balcony) AddBalcony(opening.hole, materials, panel);
      return;
  }
}

}  // namespace backsight
