#pragma once

#include <span>
#include <string>

#include "stages/simulation/campaign.h"

namespace backsight {

/// The text files of a simulated campaign; scans are named as `ScanFileName` says.

/// "scans/S1.ptx", relative to the campaign's directory.
std::string ScanFileName(const Scene& scene, const std::string& station_id);

/// Columns station,component,status,tx_m,ty_m,tz_m,qw,qx,qy,qz: survey_from_station.
std::string TruthCsv(const Campaign& campaign);

/// One line for each target and station that sees it: survey coordinates as surveyed and in truth,
/// and the measurement in the station frame.
std::string ControlCsv(const Campaign& campaign, std::span<const SimulatedTarget> targets);

/// Survey project file with the targets as control and check points, in the scene's CRS where it
/// has one, otherwise in the coordinates of its world.
std::string ProjectYaml(const Campaign& campaign, std::span<const SimulatedTarget> targets);

}  // namespace backsight
