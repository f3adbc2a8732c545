#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/option_visitor.h"

namespace backsight {

struct PairSelectionOptions {
  enum Strategy { kAuto, kExhaustive, kGrow };
  int strategy = kAuto;
  int exhaustive_stations = 12;    ///< auto: up to so many stations every pair is registered
  int full_per_station = 8;        ///< full registrations allowed, times the number of stations
  int links_per_station = 3;       ///< accepted links wanted at least
  int max_links_per_station = 10;  ///< beyond this, predicted pairs are redundant
  double predicted_overlap = 0.2;  ///< least predicted overlap of a pair worth a fine registration
  int matched_per_failure = 25;    ///< ranked of a station apart, times one more than its failures
  int matched_per_station = 200;  ///< pairs ranked by matching in all, times the number of stations
  bool until_connected = false;   ///< spend any number of registrations while components stay apart
};
void VisitOptions(OptionVisitor& visitor, PairSelectionOptions& options);

/// What is known of a pair of usable stations.
struct PairProspect {
  int source = 0;
  int target = 0;
  bool required = false;    ///< the user wants it tried
  bool excluded = false;    ///< the user forbids it
  bool too_far = false;     ///< priors place the stations too far apart
  double similarity = 0.0;  ///< larger: more likely to overlap; any scale
  bool unmatched = false;   ///< `similarity` is a mere guess: the clouds were not compared
  /// From the current poses; absent where they do not say (not in one component).
  std::optional<double> predicted_overlap;
  bool tried_full = false;
  bool tried_predicted = false;
  bool tried_thorough = false;
  bool accepted = false;  ///< a link of the network as it stands
};

enum class PairMethod {
  kFull,       ///< matching, coarse and fine registration: dear
  kPredicted,  ///< fine registration alone, from the pose that the network predicts: cheap
  kThorough,   ///< again with votes for known rotations, several times as dear as kFull
};

/// The pairs to be registered next; none: done. Indices into the candidates, no order.
struct PairBatch {
  PairMethod method = PairMethod::kFull;
  std::vector<std::size_t> pairs;
  /// If there are any, nothing is to be registered before these are ranked (MatchPairs).
  std::vector<std::size_t> to_match;
};

/// What to register next, given what is known; a pure function. Stations without a candidate (such
/// as unreadable ones) play no part. In this order, the first that has something to do:
///   1. required pairs, fully;
///   2. exhaustive (by option, or few stations): all pairs, fully, then 4 and 7;
///   3. while components are apart: every component but the largest proposes the most similar pairs
///      that leave it, for each station until it has been in full_per_station - 2 registrations;
///      stations with f registrations that did not become links first have their pairs ranked up to
///      matched_per_failure * (1 + f);
///   4. pairs within a component that the poses predict to overlap, by prediction, until both ends
///      have max_links_per_station links; stations with fewer than links_per_station are content
///      with half of the overlap;
///   5. parts that hang by a single link (2-edge-connected blocks): each but the largest proposes
///      full registrations to the others, so that every station comes onto a loop; at most four
///      registrations per station;
///   6. components still apart: the unmatched pairs between them are to be ranked first, up to
///      matched_per_station * n matched ones in all; then the most similar pairs between them,
///      until (full_per_station - 1) * n registrations are spent (until_connected: until none is
///      left);
///   7. components still apart: pairs between them thoroughly that failed fully, the most similar
///      first.
/// No pair is registered twice by the same method; one that failed fully may be predicted, and the
/// reverse. Full and thorough registrations beyond the required ones never exceed full_per_station
/// * n unless exhaustive or until_connected. Ties go to the lower index. Time O(pairs log pairs).
PairBatch NextPairs(int stations, std::span<const PairProspect> candidates,
                    const PairSelectionOptions& options);

/// True if every pair is registered fully.
bool IsExhaustive(int stations, const PairSelectionOptions& options);

/// True if NextPairs has the untried pair registered fully whatever becomes of all others, of
/// `stations` or fewer that are usable.
bool IsCertain(const PairProspect& pair, int stations, const PairSelectionOptions& options);

/// Why a candidate was never tried, as a reason code of links.csv: excluded, prior_too_far,
/// redundant (predicted to overlap, but both ends have links enough), no_overlap (the poses predict
/// too little of it), not_similar (its stations stay apart, and others were more alike). Empty
/// where it was tried.
std::string SkipReason(const PairProspect& candidate, const PairSelectionOptions& options);

}  // namespace backsight
