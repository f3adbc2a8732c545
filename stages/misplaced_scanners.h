#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/rigid_transform.h"

namespace backsight {

/// A pair's motion that chance could not have proposed, and what each station's scanner says of it:
/// the share of the other's surfaces in view that it saw through; nothing where too little is in
/// view to tell. Instrument frames.
struct MutualView {
  int source = 0;
  int target = 0;
  RigidTransform target_from_source;
  std::optional<double> seen_through_by_source;
  std::optional<double> seen_through_by_target;
};

/// Where a network puts the stations.
struct StationPlaces {
  std::span<const RigidTransform> survey_from_station;
  std::span<const int> component;
};

/// Stations that only their own scanners keep out of the network: at least three stations of one
/// component place the station alike, it saw through them by `contradiction` or more in the median,
/// and they through it by less. Its scanner then did not stand where its scan says, as in scans that
/// were moved to other coordinates. Without it the others' scanners still have to agree. Ascending.
/// `resolution_m`: places are alike within 10 of it and 5 deg.
std::vector<int> FindMisplacedScanners(std::span<const MutualView> views,
                                       const StationPlaces& places, double contradiction,
                                       double resolution_m);

}  // namespace backsight
