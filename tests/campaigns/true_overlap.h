#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

/// The scans of a campaign by station id.
using ScanPaths = std::map<std::string, std::string>;

/// Share of space that two scans have in common at their true places: of the voxels of 0.5 m that a
/// scan occupies, those that the other occupies too, the smaller of both directions. Symmetric; 0
/// for pairs that are not listed. The voxel is larger than the spacing of points on most of what a
/// coarse scan sees, and small beside a building.
using OverlapTable = std::map<std::pair<std::string, std::string>, double>;
OverlapTable TrueOverlaps(const ScanPaths& scans,
                          const std::map<std::string, RigidTransform>& truth);

/// Groups of stations that pairs with at least this overlap connect; each group has two or more.
/// Whoever is in one is placeable.
constexpr double kPlaceableOverlap = 0.15;
std::vector<std::vector<std::string>> PlaceableGroups(
    const OverlapTable& overlaps, const std::map<std::string, RigidTransform>& truth);

}  // namespace backsight
