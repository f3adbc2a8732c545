#pragma once

#include <vector>

#include "pipeline/pair_pipeline.h"
#include "stages/network_solution.h"

namespace backsight {

/// All stations with a place in the network. Indices are those of the stations; frames are the
/// stations' own and the survey frame of each component (the station frame of its first station).
struct Network {
  NetworkResult solution;         ///< instrument frames
  std::vector<int> link_of_pair;  ///< index into the solution's links; -1: not accepted
  std::vector<int> component;     ///< by size, 0 the largest; -1: connected with nothing
  std::vector<RigidTransform> survey_from_station;
  std::vector<Matrix6d> covariance;  ///< of survey_from_station, Retract's convention
};

Network BuildNetwork(const std::vector<Station>& stations, const std::vector<Pair>& pairs,
                     const NetworkOptions& options);

}  // namespace backsight
