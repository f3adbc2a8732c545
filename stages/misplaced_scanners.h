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

/// Where a network puts the stations, and whose scanner nobody vouches for.
struct StationPlaces {
  std::span<const RigidTransform> survey_from_station;
  std::span<const int> component;
  std::span<const char> scanner_assumed;
};

/// The station that most clearly only its own scanner keeps out of the network, which holds it by
/// nothing else: at least three stations of one component, the most of all such stations, place it
/// alike; it saw through them by `contradiction` or more in the median, and they through it by less
/// than half of that; by less is enough where fewer than half of them can look, as where their
/// scans are not in their scanners' frames. Its scanner then did not stand where its scan says
/// either. `resolution_m`: places are alike within 10 of it and 5 deg.
std::optional<int> FindMisplacedScanner(std::span<const MutualView> views,
                                        const StationPlaces& places, double contradiction,
                                        double resolution_m);

}  // namespace backsight
