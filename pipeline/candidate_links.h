#pragma once

#include <vector>

#include "pipeline/pair_pipeline.h"
#include "stages/network_solution.h"

namespace backsight {

/// One candidate motion of a pair as a link of the network.
struct CandidateLink {
  NetworkLink link;
  int candidate = 0;  ///< index into the candidates of pairs[link.pair]
};

/// Links for the best motion of every pair that was not rejected and, as doubtful ones, for those
/// of its rivals that were not rejected either. An accepted motion that its clouds alone prove, and
/// by a poorer fit than is common among the pairs, is doubtful too. In the order of the pairs and
/// of their candidates.
std::vector<CandidateLink> MakeCandidateLinks(const std::vector<Pair>& pairs,
                                              const VerificationOptions& options);

}  // namespace backsight
