#pragma once

#include <vector>

#include "pipeline/artifacts/pair_units.h"

namespace backsight {

/// Challenges accepted pairs with what ambiguous ones have shown. Two motions between which a pair
/// cannot decide differ by a motion under which the surroundings of its stations look the same,
/// such as the half turn of an empty hall. Where another pair of such a station was accepted
/// because nothing proposed its turned motion, that motion is refined, verified and ranked now; if
/// it is as good, the pair becomes ambiguous too. Costs nothing where no pair is ambiguous.
void ChallengeSymmetries(const PairUnits& units, std::vector<Pair>* pairs);

}  // namespace backsight
