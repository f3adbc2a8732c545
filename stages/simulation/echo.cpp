#include "stages/simulation/echo.h"

#include <cmath>

namespace backsight {
namespace {

constexpr double kAxisWeight = 0.3;
constexpr double kSamePlane = 0.001;

struct Part {
  std::size_t sub_ray = 0;
  double range_m = 0.0;
  double energy = 0.0;
};

/// A run of parts, [first, last).
struct Group {
  std::size_t first = 0;
  std::size_t last = 0;
  double energy = 0.0;
};

Group StrongestGroup(const std::array<Part, RayBundle::kSize>& parts, std::size_t count,
                     double mixing_m) {
  Group best;
  Group group;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && parts[i].range_m - parts[i - 1].range_m > mixing_m) group = {i, i, 0.0};
    group.last = i + 1;
    group.energy += parts[i].energy;
    if (group.energy > best.energy) best = group;
  }
  return best;
}

/// Share of the beam's energy that a sub-ray carries.
double SubRayWeight(std::size_t sub_ray, std::size_t count) {
  if (count == 1) return 1.0;
  return sub_ray == 0 ? kAxisWeight : (1.0 - kAxisWeight) / static_cast<double>(count - 1);
}

/// The hits in order of range; returns how many there are.
std::size_t SortedParts(const RayBundle& rays, const RayHits& hits, const RayCaster& caster,
                        std::array<Part, RayBundle::kSize>& parts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rays.count; ++i) {
    const RayHit& hit = hits[i];
    if (hit.range_m <= 0.0) continue;
    const double reflected = caster.material(hit.material).reflectance * hit.cos_incidence;
    const double energy = SubRayWeight(i, rays.count) * reflected / (hit.range_m * hit.range_m);
    std::size_t place = count++;
    for (; place > 0 && parts[place - 1].range_m > hit.range_m; --place) {
      parts[place] = parts[place - 1];
    }
    parts[place] = {i, hit.range_m, energy};
  }
  return count;
}

/// Where the beam's axis meets the plane of the hit; the sub-ray's own range if that is nowhere
/// near, as on an edge-on facet.
double RangeOnAxis(const RayBundle& rays, const RayHit& hit) {
  const double slope = hit.normal.dot(rays.directions[0]);
  if (std::abs(slope) < 0.02) return hit.range_m;
  const double range = (hit.offset_m - hit.normal.dot(rays.origins[0])) / slope;
  return std::abs(range - hit.range_m) < 0.05 ? range : hit.range_m;
}

}  // namespace

Echo BlendEchoes(const RayBundle& rays, const RayHits& hits, const RayCaster& caster,
                 double mixing_m) {
  std::array<Part, RayBundle::kSize> parts;
  const std::size_t count = SortedParts(rays, hits, caster, parts);
  Echo echo;
  if (count == 0) return echo;
  const Group group = StrongestGroup(parts, count, mixing_m);
  if (group.energy <= 0.0) return echo;

  const Part* strongest = &parts[group.first];
  for (std::size_t i = group.first; i < group.last; ++i) {
    if (parts[i].energy > strongest->energy) strongest = &parts[i];
  }
  const RayHit& reference = hits[strongest->sub_ray];
  double shift = 0.0;
  for (std::size_t i = group.first; i < group.last; ++i) {
    const std::size_t k = parts[i].sub_ray;
    const Eigen::Vector3d point = rays.origins[k] + parts[i].range_m * rays.directions[k];
    if (std::abs(reference.normal.dot(point) - reference.offset_m) < kSamePlane) continue;
    shift += parts[i].energy * (parts[i].range_m - reference.range_m);
  }
  echo.range_m = RangeOnAxis(rays, reference) + shift / group.energy;
  echo.cos_incidence = reference.cos_incidence;
  echo.signal = group.energy;
  echo.material = reference.material;
  return echo;
}

}  // namespace backsight
