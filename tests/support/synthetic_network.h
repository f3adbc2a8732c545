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

/// `stations` on a lattice of 20 m in the plane (turned about the vertical, tilted little), each
/// linked with those nearest to it: about `links_per_station` of them. Errors as in MakeNetwork.
SyntheticNetwork MakeTown(std::uint64_t seed, int stations, int links_per_station, double noise);

/// Stations in a hall that looks the same after half a turn: each pair has a true link and one that
/// the half turn of one of its stations makes of it. The true one's score is better by `lead` on
/// average; each score has normal noise of `score_noise`. Links alternate: true, turned.
SyntheticNetwork MakeHall(std::uint64_t seed, int stations, double lead, double score_noise);

/// The adjusted pose graph of one component, all links used, with the stations' covariances.
PoseGraphResult SolveWithCovariance(int stations, const std::vector<PoseGraphLink>& links);

/// Replaces a share of the links by random motions, any of them but such that each station keeps at
/// least two true ones: with one true against one false none could tell which.
std::vector<char> ReplaceByRandom(std::uint64_t seed, double share,
                                  std::vector<PoseGraphLink>* links);

/// The link that `link` becomes if its source is moved by `displacement` in the survey frame.
PoseGraphLink Displaced(const PoseGraphLink& link, const SyntheticNetwork& network,
                        const RigidTransform& displacement);

/// Gives a share of the links, but none from a station to the next, random motions; their
/// confidences tell nothing. Returns which links are false.
std::vector<char> FalsifyLinks(std::uint64_t seed, double share, std::vector<PoseGraphLink>* links);

}  // namespace backsight
