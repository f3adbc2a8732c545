#include "pipeline/candidate_links.h"

#include <algorithm>

namespace backsight {
namespace {

/// What scanners contradict says little: nothing from three times the conflict that makes a pair
/// doubtful. Places that look alike, such as the two ends of a building, yield such motions in
/// numbers that would outvote the few links that hold a long loop together.
double Credibility(const VerificationResult& verification, double sure_conflict) {
  if (!verification.sighted) return 1.0;
  const double excess = verification.conflict.value - sure_conflict;
  return std::clamp(1.0 - excess / (2.0 * sure_conflict), 0.0, 1.0);
}

NetworkLink MakeLink(const Pair& pair, std::size_t pair_index, std::size_t candidate,
                     const VerificationOptions& options) {
  const PairCandidate& motion = pair.candidates[candidate];
  NetworkLink link;
  link.pair = static_cast<int>(pair_index);
  link.source = pair.source;
  link.target = pair.target;
  link.target_from_source = motion.fine.target_from_source;
  link.information = motion.fine.information;
  link.confidence = LinkConfidence(motion);
  // Flips that put scanners on mirrored places fit better than the truth: where scanners can be
  // contradicted, only contradictions count.
  const VerificationResult& verification = motion.verification;
  link.score = verification.sighted ? -verification.conflict.value : verification.quality.value;
  link.doubtful = candidate > 0 || !pair.accepted();
  link.credibility = Credibility(verification, options.sure_conflict);
  return link;
}

}  // namespace

std::vector<CandidateLink> MakeCandidateLinks(const std::vector<Pair>& pairs,
                                              const VerificationOptions& options) {
  std::vector<CandidateLink> links;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    if (!pair.accepted() && !pair.doubtful()) continue;
    for (std::size_t c = 0; c < pair.candidates.size(); ++c) {
      if (pair.candidates[c].verification.verdict == Verdict::kRejected) continue;
      links.push_back({MakeLink(pair, p, c, options), static_cast<int>(c)});
    }
  }
  return links;
}

}  // namespace backsight
