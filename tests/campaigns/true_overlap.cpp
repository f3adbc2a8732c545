#include "tests/campaigns/true_overlap.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "core/voxel_grid.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

/// Sorted keys of the voxels that a scan occupies in the frame of the truth.
std::vector<std::uint64_t> OccupiedVoxels(const std::string& scan,
                                          const RigidTransform& truth_from_station) {
  const VoxelLattice lattice{.edge_m = 0.5};
  const PointChunk points = ReadAllPoints(scan);
  std::vector<std::uint64_t> keys;
  keys.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys.push_back(
        lattice.Key(truth_from_station * Eigen::Vector3d(points.x[i], points.y[i], points.z[i])));
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

std::size_t CommonCount(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  std::size_t count = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j)
      ++count, ++i, ++j;
    else if (*i < *j)
      ++i;
    else
      ++j;
  }
  return count;
}

}  // namespace

OverlapTable TrueOverlaps(const ScanPaths& scans,
                          const std::map<std::string, RigidTransform>& truth) {
  std::map<std::string, std::vector<std::uint64_t>> voxels;
  for (const auto& [id, pose] : truth) voxels[id] = OccupiedVoxels(scans.at(id), pose);
  OverlapTable overlaps;
  for (auto a = voxels.begin(); a != voxels.end(); ++a) {
    for (auto b = std::next(a); b != voxels.end(); ++b) {
      const std::size_t common = CommonCount(a->second, b->second);
      if (common == 0) continue;
      const double share = static_cast<double>(common) /
                           static_cast<double>(std::max(a->second.size(), b->second.size()));
      overlaps[{a->first, b->first}] = overlaps[{b->first, a->first}] = share;
    }
  }
  return overlaps;
}

std::vector<std::vector<std::string>> PlaceableGroups(
    const OverlapTable& overlaps, const std::map<std::string, RigidTransform>& truth) {
  std::map<std::string, std::string> group_of;
  for (const auto& [id, pose] : truth) group_of[id] = id;
  for (const auto& [pair, overlap] : overlaps) {
    if (overlap < kPlaceableOverlap) continue;
    const std::string kept = group_of.at(pair.first);
    const std::string gone = group_of.at(pair.second);
    for (auto& [id, group] : group_of) {
      if (group == gone) group = kept;
    }
  }
  std::map<std::string, std::vector<std::string>> groups;
  for (const auto& [id, group] : group_of) groups[group].push_back(id);
  std::vector<std::vector<std::string>> placeable;
  for (const auto& [group, ids] : groups) {
    if (ids.size() > 1) placeable.push_back(ids);
  }
  return placeable;
}

}  // namespace backsight
