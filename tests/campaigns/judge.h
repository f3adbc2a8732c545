#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "tests/campaigns/true_overlap.h"

namespace backsight {

/// What a run on a simulated campaign is worth against its exact truth. Relative poses are wrong
/// where they are off by more than 1 degree, or 0.2 m and 0.5 mm per metre of distance; links of
/// the final network are those with the status "accepted" to which the network left a weight.
struct Judgement {
  std::string name;
  std::uint64_t seed = 0;
  int exit_code = -1;
  int stations = 0;
  int placeable = 0;  ///< in a group of PlaceableGroups
  int placed = 0;     ///< placeable ones in the component that holds most of their group
  int components = 0;
  int pairs_in_full = 0;   ///< links.csv: pairs whose correspondences were sought
  int accepted_links = 0;  ///< of the final network
  int wrong_links = 0;     ///< of those, wrong ones
  int outvoted_links = 0;  ///< verified, then left out by the network
  int outvoted_wrong = 0;
  int wrong_pairs = 0;  ///< wrong relative poses within a component, all pairs
  double mean_te_m = 0.0, max_te_m = 0.0, max_re_deg = 0.0;  ///< to each component's first station
  /// Of every placed station but each component's first: position error over the stated one
  /// (root of the trace of the position's covariance), and xi^T C^-1 xi / 6.
  std::vector<double> error_to_sigma, nees_per_dof;
  double seconds = 0.0;
  std::vector<std::string> faults;  ///< a line for each wrong link and each unplaced station
};

/// Reads poses.csv, poses.json and links.csv of `folder`/out and truth.csv of `folder`.
Judgement Judge(const std::string& folder, const ScanPaths& scans);

/// Percentile by linear interpolation, 0 to 1; NaN for no values.
double Percentile(std::vector<double> values, double share);
double Mean(const std::vector<double>& values);

std::string JudgementHeader();
std::string JudgementLine(const Judgement& judgement);

/// Sums of counts, all stations' ratios together.
Judgement Total(const std::vector<Judgement>& judgements);

}  // namespace backsight
