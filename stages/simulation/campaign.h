#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "io/scene_description.h"
#include "stages/simulation/ground_model.h"
#include "stages/simulation/scanner_model.h"
#include "stages/simulation/triangle_mesh.h"

namespace backsight {

/// Where a station truly stands. The survey frame is the frame of the first station.
struct StationTruth {
  std::string id;
  RigidTransform world_from_station;
  RigidTransform survey_from_station;
};

/// A synthetic campaign before measuring: what stands still, and the truth.
struct Campaign {
  Scene scene;
  GroundModel ground;
  TriangleMesh still;  ///< everything but people and traffic
  std::vector<StationTruth> stations;
};

/// Draws the geometry and the stations' orientations from the scene's seed. The scene needs at
/// least one station.
Campaign PrepareCampaign(const Scene& scene);

/// Scans from one station. Time is about 1 us a ray and thread, plus building the ray caster.
StationScan SimulateStation(const Campaign& campaign, std::size_t station,
                            const ExecutionContext& execution);

/// A target as one station measured it, station frame.
struct TargetMeasurement {
  std::size_t station = 0;
  Eigen::Vector3d xyz_m = Eigen::Vector3d::Zero();
};

struct SimulatedTarget {
  ControlSite site;
  Eigen::Vector3d true_survey_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d surveyed_m = Eigen::Vector3d::Zero();  ///< the truth with the survey's noise
  std::vector<TargetMeasurement> measured;  ///< one for each station that sees the target
};

/// Surveys every target, and measures it from every station that has it within its range and field
/// of view with nothing that stands still (people and cars wait) in between.
std::vector<SimulatedTarget> MeasureTargets(const Campaign& campaign);

}  // namespace backsight
