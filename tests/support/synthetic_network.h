#pragma once

#include <utility>
#include <vector>

#include "core/random.h"
#include "graph/pose_graph.h"

namespace backsight {

/// A network of stations with known poses; station 0 is the datum.
struct SyntheticNetwork {
  std::vector<RigidTransform> survey_from_station;
  std::vector<PoseGraphLink> links;
};

/// `stations` within 30 m, every pair linked with probability `density` (and each station with the
/// one before it). Each link's measurement is off by a draw from a random covariance scaled by
/// `noise` (1: some millimetres and hundredths of a degree); its information is that covariance's
/// inverse, that of noise 1 where `noise` is 0.
SyntheticNetwork MakeNetwork(std::uint64_t seed, int stations, double density, double noise);

/// Gives a share of the links, but none from a station to the next, random motions; their
/// confidences tell nothing. Returns which links are false.
std::vector<char> FalsifyLinks(std::uint64_t seed, double share, std::vector<PoseGraphLink>* links);

}  // namespace backsight
