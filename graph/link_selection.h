#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "graph/cycle_consistency.h"
#include "graph/pose_graph.h"
#include "graph/rival_placements.h"

namespace backsight {

/// What became of a link.
enum class LinkFate {
  kUsed,                ///< it is in the solution
  kContradictsNetwork,  ///< beyond what its errors allow from where the other links put its ends
  kRivalWon,            ///< another motion of the same pair is used
  kUnconfirmed,         ///< doubtful, and no loop of other links confirms it
  kAmbiguous            ///< as likely as another placement of the same stations: neither is used
};

/// The reason code of links.csv, e.g. "contradicts_network"; empty for kUsed.
std::string ToString(LinkFate fate);

/// Stations that could stand in two ways, between which the links do not decide. They are cut off
/// from the rest rather than guessed.
struct Ambiguity {
  std::vector<int> stations;             ///< the smaller side of the cut (ties: without station 0)
  int for_kept = 0, for_rival = 0;       ///< links across the cut that speak for either
  double margin = 0.0, noise = 0.0;      ///< RivalPlacement's
  double shift_m = 0.0, turn_deg = 0.0;  ///< between the two placements, at the first of them
};

struct SelectionOptions {
  double outlier_limit = 100.0;  ///< squared error beyond which a link contradicts the network
  /// The same for a link on cycles none of which closes: chi^2, 6 degrees of freedom, 99 %. Long
  /// tails are granted to those only that something supports.
  double unsupported_limit = 16.81;
  double score_noise = 0.02;           ///< standard deviation of a link's score
  int max_iterations = 100;            ///< of one adjustment
  std::function<void()> between = {};  ///< called between adjustments; may throw to give up
};

struct LinkSelection {
  std::vector<LinkFate> fate;                       ///< per link
  std::vector<RigidTransform> survey_from_station;  ///< adjusted with the used links
  std::vector<int> component;                       ///< by the used links
  std::vector<Ambiguity> ambiguities;
  int moves = 0;       ///< better placements taken
  int readmitted = 0;  ///< links used that the first tree contradicted
  std::vector<char> Used() const;
};

/// Chooses the links that belong together, at most one of each pair, so that the start values of an
/// adjustment do not hang on false ones:
///   1. a forest over the links in the order of their cycles, then of their lead over rivals, then
///   of
///      confidence; doubtful links only where cycles confirm them or a loop of parts closes;
///   2. the links that close a loop with it within outlier_limit, with the errors along the forest;
///      adjustment; then links within outlier_limit in, others out, to a fixed point;
///   3. stations to better places as long as there are any (FindRivalPlacements);
///   4. doubtful links that neither a way over accepted links confirms nor two ways over doubtful
///      ones between the parts that accepted links hold together: out;
///   5. where two placements are equally likely, the links between the parts: out.
/// Steps 2 to 5 repeat until nothing changes. `support` is CheckCycles' with CountPartLoops'. The
/// information matrices must be of the right scale.
LinkSelection SelectLinks(int stations, std::span<const PoseGraphLink> links,
                          std::span<const LinkSupport> support, const SelectionOptions& options);

}  // namespace backsight
