#include "stages/simulation/ray_caster.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <string>

#include "core/error.h"

namespace backsight {
namespace {

constexpr unsigned kOpaqueMask = 1;
constexpr unsigned kGlassMask = 2;

/// Embree reports a failure of a call through the device only.
void CheckDevice(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  BACKSIGHT_CHECK(error == RTC_ERROR_NONE, "Embree error " + std::to_string(error));
}

}  // namespace

struct RayCaster::Scene {
  explicit Scene(TriangleMesh source) : mesh(std::move(source)), device(rtcNewDevice(nullptr)) {
    BACKSIGHT_CHECK(device != nullptr, "Embree could not be started");
    scene = rtcNewScene(device);
    // Robust: no ray slips through the common edge of two triangles.
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const bool glass = mesh.materials[mesh.triangle_materials[i]].glass;
      members[glass ? 1 : 0].push_back(i);
    }
    AttachGeometry(0, kOpaqueMask);
    AttachGeometry(1, kGlassMask);
    rtcCommitScene(scene);
    CheckDevice(device);
  }
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  void AttachGeometry(unsigned id, unsigned mask) {
    if (members[id].empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             3 * sizeof(float), mesh.vertices.size());
    std::memcpy(vertices, mesh.vertices.data()->data(), mesh.vertices.size() * 3 * sizeof(float));
    auto* corners = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), members[id].size()));
    for (const std::uint32_t triangle : members[id]) {
      for (const std::uint32_t corner : mesh.triangles[triangle]) *corners++ = corner;
    }
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  }

  RayHit ExactHit(std::uint32_t triangle, const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction) const {
    const auto& corners = mesh.triangles[triangle];
    const Eigen::Vector3d a = mesh.vertices[corners[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[corners[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[corners[2]].cast<double>();
    RayHit hit;
    hit.normal = (b - a).cross(c - a).normalized();
    hit.offset_m = hit.normal.dot(a);
    const double slope = hit.normal.dot(direction);
    hit.cos_incidence = std::abs(slope);
    hit.range_m = (hit.offset_m - hit.normal.dot(origin)) / slope;
    hit.material = mesh.triangle_materials[triangle];
    return hit;
  }

  TriangleMesh mesh;
  std::array<std::vector<std::uint32_t>, 2> members;  // opaque, glass: triangles of the mesh
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

RayCaster::RayCaster(TriangleMesh mesh) : scene_(std::make_unique<Scene>(std::move(mesh))) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

RayHits RayCaster::Cast(const RayBundle& rays, double max_range_m, bool through_glass) const {
  RTCRayHit8 packet;
  alignas(32) std::array<int, RayBundle::kSize> valid{};
  for (std::size_t i = 0; i < RayBundle::kSize; ++i) {
    valid[i] = i < rays.count ? -1 : 0;
    const std::size_t source = i < rays.count ? i : 0;
    packet.ray.org_x[i] = static_cast<float>(rays.origins[source].x());
    packet.ray.org_y[i] = static_cast<float>(rays.origins[source].y());
    packet.ray.org_z[i] = static_cast<float>(rays.origins[source].z());
    packet.ray.dir_x[i] = static_cast<float>(rays.directions[source].x());
    packet.ray.dir_y[i] = static_cast<float>(rays.directions[source].y());
    packet.ray.dir_z[i] = static_cast<float>(rays.directions[source].z());
    packet.ray.tnear[i] = 0.0F;
    packet.ray.tfar[i] = static_cast<float>(max_range_m);
    packet.ray.time[i] = 0.0F;
    packet.ray.mask[i] = through_glass ? kOpaqueMask : kOpaqueMask | kGlassMask;
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid.data(), scene_->scene, &context, &packet);

  RayHits hits;
  for (std::size_t i = 0; i < rays.count; ++i) {
    const unsigned geometry = packet.hit.geomID[i];
    if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
    const std::uint32_t triangle = scene_->members[geometry][packet.hit.primID[i]];
    const RayHit hit = scene_->ExactHit(triangle, rays.origins[i], rays.directions[i]);
    // Edge-on triangles give no usable intersection.
    if (std::isfinite(hit.range_m) && hit.range_m > 0.0 && hit.range_m <= max_range_m) {
      hits[i] = hit;
    }
  }
  return hits;
}

bool RayCaster::IsFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  RayBundle ray;
  ray.count = 1;
  ray.origins[0] = from;
  ray.directions[0] = (to - from).normalized();
  return Cast(ray, (to - from).norm(), true)[0].range_m == 0.0;
}

const Material& RayCaster::material(MaterialId id) const { return scene_->mesh.materials[id]; }

}  // namespace backsight
