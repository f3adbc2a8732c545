#pragma once

#include <span>
#include <vector>

#include "graph/pose_graph.h"

namespace backsight {

/// A second way to place some stations of a network: all of them moved by one displacement, as
/// links that the network does not use would have it. A symmetric hall turned by half, a facade
/// shifted by one bay.
struct RivalPlacement {
  std::vector<int> stations;    ///< that would move, sorted
  RigidTransform displacement;  ///< survey frame: pose <- displacement * pose
  std::vector<int> links;       ///< unused links across the cut that it would fulfil
  int kept = 0;                 ///< used links across the cut, which it would break
  /// Used links that may be the false ones if `links` are true: those across any undecided cut for
  /// the same displacement, where some of `links` has no used rival (a contradiction that is gone
  /// once they are); else those across this cut.
  std::vector<int> suspects;
  /// How much speaks against it, in standard deviations of one pair's score; negative: it is
  /// better.
  double margin = 0.0;
  /// What `margin` must reach: three standard deviations, of variance 1 for a pair that both sides
  /// explain and 2, times its link's credibility, for one that only one side does. Without scores 2
  /// links decide against none, 6 against 2, 8 against 3.
  double noise = 0.0;
  bool Undecided() const { return margin < noise; }
};

struct RivalOptions {
  /// Of a squared error: an unused link within it of the network is noise and no rival, and two
  /// rivals within it mean the same displacement.
  double limit = 100.0;
  double score_noise = 0.02;  ///< standard deviation of a link's score
  /// An unused link that differs from the network by less than both is a poor measurement of the
  /// same place, not another place.
  double least_turn_rad = 0.0175;  // 1 deg
  double least_shift_m = 0.2;
};

/// What a pair says for its used link against an unused one, in standard deviations: the difference
/// of scores over its noise, at most 3 either way. A pair that only one side can explain counts 3
/// times its link's credibility.
inline constexpr double kFullVote = 3.0;

/// Credibility from which a doubtful link counts against or for others by itself.
inline constexpr double kLeastCredibility = 0.5;

/// For each displacement that unused links ask for, the set of stations with the least margin less
/// noise, if there is any that two links speak for or that a single used link holds. Only links
/// with `eligible[l]` count. Sets are grown greedily from both ends of each asking link, the
/// station with the least margin first: exact where the best set is within reach of such growth,
/// which tests/graph/rival_placements_test.cpp holds against all sets. Lone links inside a part of
/// the network that no single link holds together, and doubtful ones that are hardly credible, are
/// outliers and skipped. Time O(rivals^2 +
/// rivals * stations * links per station).
std::vector<RivalPlacement> FindRivalPlacements(std::span<const PoseGraphLink> links,
                                                std::span<const char> eligible,
                                                std::span<const char> used,
                                                std::span<const RigidTransform> poses,
                                                const RivalOptions& options);

}  // namespace backsight
