#pragma once

#include <optional>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "io/survey_project.h"
#include "stages/pair_selection.h"
#include "stages/station_model.h"

namespace backsight {

struct PairRankingOptions {
  int words = 64;                 ///< of the vocabulary of the stations' signatures
  int prematch_per_station = 25;  ///< the most similar of each station that are matched cheaply
  int prematch_keypoints = 600;   ///< of each station
};
void VisitOptions(OptionVisitor& visitor, PairRankingOptions& options);

/// What the ranking needs of a station.
struct RankedStation {
  const StationModel* model = nullptr;        ///< null: the station cannot be used
  const StationFeatures* features = nullptr;  ///< likewise
  bool levelled = false;
  double range_m = 0.0;  ///< useful range
  std::optional<StationPrior> prior;
};

/// Sets `similarity` of every candidate: the score of a cheap match for those of
/// each station with the best signatures, which all pairs are of up to 26 stations; the rest
/// come last, by their signatures, and are marked `unmatched`. Pairs that both stations' priors
/// place near each other come first, nearest first. Time 3 us a pair, and some 10 ms for each pair
/// matched; does not depend on the threads.
void RankPairs(const std::vector<RankedStation>& stations, const PairRankingOptions& options,
               const ExecutionContext& context, std::vector<PairProspect>* candidates);

/// Matches the unmatched candidates `which` (indices), so that they rank among the matched ones.
/// Time some 10 ms for each and as much for each station that takes part; threads as above.
void MatchPairs(const std::vector<RankedStation>& stations, const PairRankingOptions& options,
                const ExecutionContext& context, const std::vector<std::size_t>& which,
                std::vector<PairProspect>* candidates);

}  // namespace backsight
