#pragma once

#include <functional>
#include <vector>

#include "core/random.h"
#include "stages/network_refinement.h"

namespace backsight {

/// Stations in a hall of 20 m whose walls, floor and ceiling are plates of 0.7 m, and the pose
/// graph's view of them.
struct PlateCampaign {
  std::vector<StationModel> models;
  std::vector<RigidTransform> truth;  ///< identity for the first
  NetworkRefinementInput input;
};

struct PlateCampaignOptions {
  int stations = 4;
  int plates = 8;   ///< per row and column of a wall
  int points = 60;  ///< per plate and station
  double noise_m = 0.002;
  double tilt_rad = 0.05;           ///< largest, per axis
  double link_shift_sigma = 0.004;  ///< m, per axis
  double link_turn_sigma = 3e-4;    ///< rad
  double link_error = 1.0;          ///< in standard deviations; 0: links are exact
  /// Where a station measures a point of the hall, survey frame; empty: where it is.
  std::function<Eigen::Vector3d(int station, const Eigen::Vector3d& point)> measured = {};
  /// Whether a station sees a point; empty: whatever is not hidden by chance.
  std::function<bool(int station, const Eigen::Vector3d& point)> seen = {};
  /// Points on other things in the hall that an instrument at a place measures; empty: none.
  std::function<std::vector<Eigen::Vector3d>(Random& random, const Eigen::Vector3d& instrument)>
      things = {};
};

PlateCampaign MakePlateCampaign(std::uint64_t seed, const PlateCampaignOptions& options);

/// Start poses and covariances anew from the links.
void SolveGraph(PlateCampaign* campaign);

NetworkRefinementResult Refine(PlateCampaign& campaign,
                               const NetworkRefinementOptions& options = {}, int threads = 1);

}  // namespace backsight
