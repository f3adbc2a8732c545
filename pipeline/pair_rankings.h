#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/artifacts/pair_units.h"
#include "stages/pair_selection.h"

namespace backsight {

/// RankPairs over the stations of `units`, from the store where it holds the ranking.
void RankOnce(const PairUnits& units, std::vector<PairProspect>* candidates);

/// MatchPairs likewise, for the `round`-th time in a discovery.
void MatchOnce(const PairUnits& units, const std::vector<std::size_t>& which, int round,
               std::vector<PairProspect>* candidates);

}  // namespace backsight
