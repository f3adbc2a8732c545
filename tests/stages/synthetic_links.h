#pragma once

#include <algorithm>
#include <vector>

#include "stages/network_solution.h"
#include "tests/support/synthetic_network.h"

namespace backsight {

/// Without a floor under the errors: those of synthetic networks are what they say.
inline NetworkOptions Exact() {
  NetworkOptions options;
  options.floor_rotation_deg = 0.0;
  options.floor_translation_m = 0.0;
  options.score_noise = 0.02;  // as the synthetic halls have it
  return options;
}

inline std::vector<NetworkLink> ToNetworkLinks(const std::vector<PoseGraphLink>& links) {
  std::vector<NetworkLink> result;
  for (std::size_t l = 0; l < links.size(); ++l) {
    const PoseGraphLink& link = links[l];
    NetworkLink made;
    made.pair = link.pair >= 0 ? link.pair : static_cast<int>(l);
    made.source = link.source;
    made.target = link.target;
    made.target_from_source = link.target_from_source;
    made.information = link.information;
    made.confidence = link.confidence;
    made.score = link.score;
    made.doubtful = link.doubtful;
    result.push_back(made);
  }
  return result;
}

inline NetworkResult Solve(const SyntheticNetwork& network,
                           const NetworkOptions& options = Exact()) {
  return SolveNetwork(static_cast<int>(network.survey_from_station.size()),
                      ToNetworkLinks(network.links), options);
}

inline double LargestDistance(const std::vector<RigidTransform>& a,
                              const std::vector<RigidTransform>& b) {
  double largest = 0.0;
  for (std::size_t s = 0; s < a.size(); ++s) {
    largest = std::max(largest, (a[s].translation - b[s].translation).norm());
  }
  return largest;
}

inline SyntheticNetwork Without(const SyntheticNetwork& network,
                                const std::vector<char>& leave_out) {
  SyntheticNetwork rest = network;
  rest.links.clear();
  for (std::size_t l = 0; l < network.links.size(); ++l) {
    if (leave_out[l] == 0) rest.links.push_back(network.links[l]);
  }
  return rest;
}

inline int Count(const NetworkResult& result, LinkFate fate) {
  return static_cast<int>(std::count(result.fate.begin(), result.fate.end(), fate));
}

}  // namespace backsight
