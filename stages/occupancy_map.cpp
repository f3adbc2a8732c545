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

/// Keeps the map within its memory while it grows.
class MemoryGuard {
 public:
  MemoryGuard(const octomap::OcTree& map, const OccupancyMapOptions& options,
              const ExecutionContext& context)
      : map_(map), options_(options), context_(context) {}

  /// The map has grown: looks at all of it.
  void Measure() {
    map_bytes_ = map_.memoryUsage();
    Check(0);
  }

  /// `crossed` voxels are held beside the map.
  void Check(std::size_t crossed) const {
    constexpr std::size_t kKeyBytes = 48;  // of a key in a hash set
    context_.CheckStop();
    // The file is a copy of what the map holds.
    const std::size_t needed = 2 * map_bytes_ + crossed * kKeyBytes;
    if (needed <= options_.memory_bytes) return;
    throw InputError({"outputs.map",
                      fmt::format("resolution_m: {} needs more than {} MB of memory",
                                  options_.resolution_m, options_.memory_bytes >> 20U),
                      "a map that fits", "state a coarser resolution_m, or map: none"});
  }

 private:
  const octomap::OcTree& map_;
  const OccupancyMapOptions& options_;
  const ExecutionContext& context_;
  std::size_t map_bytes_ = 0;
};

/// The voxels in which the station measured what stands still.
octomap::KeySet StillVoxels(const octomap::OcTree& map, const PlacedSurface& placed,
                            const MovingLeaves& moving, double scale) {
  octomap::KeySet voxels;
  const auto& leaves = placed.surface.model.leaves;
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    if (std::binary_search(moving.leaves.begin(), moving.leaves.end(), i)) continue;
    voxels.insert(KeyOf(map, placed.frame_from_instrument * (scale * leaves[i].cluster.mean)));
  }
  return voxels;
}

/// The voxels that the beams cross from the station to the centres of `ends`.
octomap::KeySet CrossedVoxels(const octomap::OcTree& map, const Eigen::Vector3d& station,
                              const octomap::KeySet& ends, const MemoryGuard& guard) {
  constexpr std::size_t kBeamsAtOnce = 1000;
  const octomap::point3d origin = ToOctomap(station);
  octomap::KeySet crossed;
  octomap::KeyRay ray;
  std::size_t beams = 0;
  for (const octomap::OcTreeKey& end : ends) {
    if (map.computeRayKeys(origin, map.keyToCoord(end), ray)) {
      crossed.insert(ray.begin(), ray.end());
    }
    if (++beams % kBeamsAtOnce == 0) guard.Check(crossed.size());
  }
  return crossed;
}

}  // namespace

std::string DrawOccupancyMap(const std::vector<PlacedSurface>& surfaces,
                             const std::vector<MovingLeaves>& moving,
                             const OccupancyMapOptions& options, const ExecutionContext& context) {
  constexpr bool kLazy = true;
  octomap::OcTree map(options.resolution_m);
  MemoryGuard guard(map, options, context);
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    for (const auto& key : StillVoxels(map, surfaces[s], moving[s], options.scale)) {
      map.updateNode(key, true, kLazy);
    }
    guard.Measure();
  }
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    if (!surfaces[s].surface.scanner_credible) continue;
    const octomap::KeySet ends = StillVoxels(map, surfaces[s], moving[s], options.scale);
    const Eigen::Vector3d station = surfaces[s].frame_from_instrument.translation;
    for (const auto& key : CrossedVoxels(map, station, ends, guard)) {
      const octomap::OcTreeNode* node = map.search(key);
      const bool is_occupied = node != nullptr && map.isNodeOccupied(node);
      if (!is_occupied) map.updateNode(key, false, kLazy);
    }
    guard.Measure();
  }
  map.updateInnerOccupancy();
  map.prune();
  std::ostringstream bytes;
  if (!map.write(bytes)) throw InternalError("an occupancy map could not be serialised");
  return std::move(bytes).str();
}

}  // namespace backsight
