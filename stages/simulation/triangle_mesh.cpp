#include "stages/simulation/triangle_mesh.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace backsight {
namespace {

constexpr double kMinArea = 1e-10;

double Area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace

MaterialId AddMaterial(const Material& material, TriangleMesh& mesh) {
  BACKSIGHT_CHECK(mesh.materials.size() < 65535, "too many materials in a scene");
  mesh.materials.push_back(material);
  return static_cast<MaterialId>(mesh.materials.size() - 1);
}

void AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 MaterialId material, TriangleMesh& mesh) {
  if (Area(a, b, c) < kMinArea) return;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Eigen::Vector3d& corner : {a, b, c}) mesh.vertices.push_back(corner.cast<float>());
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangle_materials.push_back(material);
}

void AddQuad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
             const Eigen::Vector3d& d, MaterialId material, TriangleMesh& mesh) {
  AddTriangle(a, b, c, material, mesh);
  AddTriangle(a, c, d, material, mesh);
}

void AddBox(const RigidTransform& world_from_local, const Eigen::Vector3d& min,
            const Eigen::Vector3d& max, MaterialId material, TriangleMesh& mesh) {
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = world_from_local * Eigen::Vector3d((i & 1U) != 0 ? max.x() : min.x(),
                                                    (i & 2U) != 0 ? max.y() : min.y(),
                                                    (i & 4U) != 0 ? max.z() : min.z());
  }
  constexpr std::array<std::array<std::size_t, 4>, 6> kFaces = {
      {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}};
  for (const auto& f : kFaces) {
    AddQuad(corners[f[0]], corners[f[1]], corners[f[2]], corners[f[3]], material, mesh);
  }
}

void AddTube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double from_radius_m,
             double to_radius_m, int segments, MaterialId material, TriangleMesh& mesh) {
  const Eigen::Vector3d u = (to - from).unitOrthogonal();
  const Eigen::Vector3d v = (to - from).normalized().cross(u);
  const auto spoke = [&](int i) -> Eigen::Vector3d {
    const double angle = 2.0 * std::numbers::pi * (i % segments) / segments;
    return std::cos(angle) * u + std::sin(angle) * v;
  };
  for (int i = 0; i < segments; ++i) {
    const Eigen::Vector3d a = spoke(i);
    const Eigen::Vector3d b = spoke(i + 1);
    AddQuad(from + from_radius_m * a, from + from_radius_m * b, to + to_radius_m * b,
            to + to_radius_m * a, material, mesh);
    AddTriangle(from, from + from_radius_m * a, from + from_radius_m * b, material, mesh);
    AddTriangle(to, to + to_radius_m * a, to + to_radius_m * b, material, mesh);
  }
}

void AddEllipsoid(const Eigen::Vector3d& center, const Eigen::Vector3d& radii_m,
                  MaterialId material, TriangleMesh& mesh) {
  constexpr int kRings = 8;
  constexpr int kSegments = 12;
  const auto at = [&](int ring, int segment) -> Eigen::Vector3d {
    const double polar = std::numbers::pi * ring / kRings;
    const double azimuth = 2.0 * std::numbers::pi * (segment % kSegments) / kSegments;
    return center + radii_m.cwiseProduct(Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                         std::sin(polar) * std::sin(azimuth),
                                                         std::cos(polar)));
  };
  for (int r = 0; r < kRings; ++r) {
    for (int s = 0; s < kSegments; ++s) {
      AddQuad(at(r, s), at(r, s + 1), at(r + 1, s + 1), at(r + 1, s), material, mesh);
    }
  }
}

void AddPrism(const RigidTransform& world_from_local, std::span<const Eigen::Vector2d> profile,
              double half_width_m, double taper_m, MaterialId material, TriangleMesh& mesh) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : profile) middle += p / static_cast<double>(profile.size());
  const auto at = [&](const Eigen::Vector2d& p, double y) {
    return world_from_local * Eigen::Vector3d(p.x(), y, p.y());
  };
  const auto inset = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    const Eigen::Vector2d offset = p - middle;
    return middle + offset * std::max(0.0, 1.0 - taper_m / offset.norm());
  };
  const double edge = half_width_m - taper_m;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const Eigen::Vector2d& a = profile[i];
    const Eigen::Vector2d& b = profile[(i + 1) % profile.size()];
    AddQuad(at(a, -edge), at(b, -edge), at(b, edge), at(a, edge), material, mesh);
    for (const double side : {-1.0, 1.0}) {
      AddQuad(at(a, side * edge), at(b, side * edge), at(inset(b), side * half_width_m),
              at(inset(a), side * half_width_m), material, mesh);
      AddTriangle(at(middle, side * half_width_m), at(inset(a), side * half_width_m),
                  at(inset(b), side * half_width_m), material, mesh);
    }
  }
}

TriangleMesh TrianglesWithin(const TriangleMesh& mesh, const Eigen::Vector3d& center,
                             double radius_m) {
  TriangleMesh part;
  part.materials = mesh.materials;
  const Eigen::Vector3f low = (center.array() - radius_m).cast<float>();
  const Eigen::Vector3f high = (center.array() + radius_m).cast<float>();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& corners = mesh.triangles[i];
    const Eigen::Vector3f& a = mesh.vertices[corners[0]];
    const Eigen::Vector3f& b = mesh.vertices[corners[1]];
    const Eigen::Vector3f& c = mesh.vertices[corners[2]];
    const Eigen::Vector3f min = a.cwiseMin(b).cwiseMin(c);
    const Eigen::Vector3f max = a.cwiseMax(b).cwiseMax(c);
    if ((min.array() > high.array()).any() || (max.array() < low.array()).any()) continue;
    const auto first = static_cast<std::uint32_t>(part.vertices.size());
    for (const Eigen::Vector3f& corner : {a, b, c}) part.vertices.push_back(corner);
    part.triangles.push_back({first, first + 1, first + 2});
    part.triangle_materials.push_back(mesh.triangle_materials[i]);
  }
  return part;
}

RigidTransform UprightFrame(const Eigen::Vector3d& origin, double heading_deg) {
  const double heading = heading_deg * std::numbers::pi / 180.0;
  return {ExpSo3(Eigen::Vector3d(0.0, 0.0, heading)), origin};
}

}  // namespace backsight
