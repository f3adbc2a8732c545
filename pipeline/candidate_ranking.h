#pragma once

#include <vector>

#include "pipeline/pair_pipeline.h"

namespace backsight {

/// Keeps the better refined of those that are one motion, and puts the best candidate first: among
/// those that no scanner contradicts significantly more than the least contradicted, the one whose
/// surfaces fit best. Where another fits as well, no candidate is accepted.
void RankCandidates(double resolution_m, std::vector<PairCandidate>* candidates);

}  // namespace backsight
