#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

/// How a surface answers a laser pulse.
struct Material {
  double reflectance = 0.5;                     ///< diffuse, 0 to 1
  std::array<double, 3> rgb = {0.5, 0.5, 0.5};  ///< 0 to 1
  bool glass = false;                           ///< mostly lets the pulse through
  bool moving = false;                          ///< elsewhere in every scan
};

using MaterialId = std::uint16_t;

/// A soup of triangles with one material each, world frame, metres.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<MaterialId> triangle_materials;  ///< one for each triangle
  std::vector<Material> materials;
};

MaterialId AddMaterial(const Material& material, TriangleMesh& mesh);

void AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 MaterialId material, TriangleMesh& mesh);

/// Corners in order around the quadrangle. Degenerate quadrangles are left out.
void AddQuad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
             const Eigen::Vector3d& d, MaterialId material, TriangleMesh& mesh);

/// All six faces of the box between `min` and `max` of a local frame.
void AddBox(const RigidTransform& world_from_local, const Eigen::Vector3d& min,
            const Eigen::Vector3d& max, MaterialId material, TriangleMesh& mesh);

/// A closed truncated cone between two points, world frame.
void AddTube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double from_radius_m,
             double to_radius_m, int segments, MaterialId material, TriangleMesh& mesh);

void AddEllipsoid(const Eigen::Vector3d& center, const Eigen::Vector3d& radii_m,
                  MaterialId material, TriangleMesh& mesh);

/// Extrudes a convex polygon of the local x-z plane along y; the far and near faces may be narrower
/// than the polygon's plane by `taper` (0: a straight prism), which rounds a body's flanks.
void AddPrism(const RigidTransform& world_from_local, std::span<const Eigen::Vector2d> profile,
              double half_width_m, double taper_m, MaterialId material, TriangleMesh& mesh);

/// The triangles that reach into the cube of half edge `radius_m` about `center`; materials keep
/// their ids. O(n).
TriangleMesh TrianglesWithin(const TriangleMesh& mesh, const Eigen::Vector3d& center,
                             double radius_m);

/// The frame at `origin` turned by `heading_deg` about the vertical.
RigidTransform UprightFrame(const Eigen::Vector3d& origin, double heading_deg);

}  // namespace backsight
