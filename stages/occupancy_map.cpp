#include "stages/occupancy_map.h"

#include <fmt/format.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <sstream>

#include "core/error.h"

namespace backsight {
namespace {

octomap::point3d ToOctomap(const Eigen::Vector3d& point) {
  const Eigen::Vector3f p = point.cast<float>();
  return {p.x(), p.y(), p.z()};
}

octomap::OcTreeKey KeyOf(const octomap::OcTree& map, const Eigen::Vector3d& point) {
  octomap::OcTreeKey key;
  if (!map.coordToKeyChecked(ToOctomap(point), key)) {
    throw InputError({"outputs.map",
                      fmt::format("resolution_m: {} for points {:.0f} m from the frame's origin",
                                  map.getResolution(), point.norm()),
                      "points within 32768 voxels of it", "state a coarser resolution_m"});
  }
  return key;
}

/// The voxels in which the station measured what stands still.
octomap::KeySet StillVoxels(const octomap::OcTree& map, const PlacedSurface& placed,
                            const MovingLeaves& moving) {
  octomap::KeySet voxels;
  const auto& leaves = placed.surface.model.leaves;
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    if (std::binary_search(moving.leaves.begin(), moving.leaves.end(), i)) continue;
    voxels.insert(KeyOf(map, placed.frame_from_instrument * leaves[i].cluster.mean));
  }
  return voxels;
}

/// The voxels that the beams cross from the station to the centres of `ends`.
octomap::KeySet CrossedVoxels(const octomap::OcTree& map, const Eigen::Vector3d& station,
                              const octomap::KeySet& ends) {
  const octomap::point3d origin = ToOctomap(station);
  octomap::KeySet crossed;
  octomap::KeyRay ray;
  for (const octomap::OcTreeKey& end : ends) {
    if (map.computeRayKeys(origin, map.keyToCoord(end), ray)) {
      crossed.insert(ray.begin(), ray.end());
    }
  }
  return crossed;
}

}  // namespace

std::string DrawOccupancyMap(const std::vector<PlacedSurface>& surfaces,
                             const std::vector<MovingLeaves>& moving, double resolution_m,
                             const ExecutionContext& context) {
  constexpr bool kLazy = true;
  octomap::OcTree map(resolution_m);
  std::vector<octomap::KeySet> still(surfaces.size());
  octomap::KeySet occupied;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    still[s] = StillVoxels(map, surfaces[s], moving[s]);
    occupied.insert(still[s].begin(), still[s].end());
    for (const octomap::OcTreeKey& key : still[s]) map.updateNode(key, true, kLazy);
  }
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    context.CheckStop();
    const Eigen::Vector3d station = surfaces[s].frame_from_instrument.translation;
    if (!surfaces[s].surface.scanner_credible) continue;
    for (const octomap::OcTreeKey& key : CrossedVoxels(map, station, still[s])) {
      if (occupied.count(key) == 0) map.updateNode(key, false, kLazy);
    }
  }
  map.updateInnerOccupancy();
  map.prune();
  std::ostringstream bytes;
  if (!map.write(bytes)) throw InternalError("an occupancy map could not be serialised");
  return std::move(bytes).str();
}

}  // namespace backsight
