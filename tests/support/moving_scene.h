#pragma once

#include <memory>
#include <vector>

#include "stages/moving_objects.h"
#include "stages/simulation/campaign.h"

namespace backsight {

/// One simulated scan and what the stages make of it.
struct ScannedStation {
  StationScan scan;
  StationModel model;
  StationFeatures features;
  std::unique_ptr<CloudIndex> index;
};

/// Simulated stations at their true places.
struct ScannedCampaign {
  std::vector<ScannedStation> stations;
  std::vector<RigidTransform> survey_from_station;
  RigidTransform world_from_survey;
  GroundModel ground;

  /// Refers to this campaign.
  std::vector<PlacedSurface> Placed() const;
};

/// Five stations in a street with parked cars, trees, poles and a fence; eight people and four cars
/// are elsewhere in every scan.
Scene BusyStreet(std::uint64_t seed);
/// Four stations in a furnished hall with pillars in which six people walk.
Scene BusyHall(std::uint64_t seed);

ScannedCampaign ScanCampaign(const Scene& scene, const ExecutionContext& context);

}  // namespace backsight
