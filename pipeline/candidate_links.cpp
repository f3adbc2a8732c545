#include "pipeline/candidate_links.h"

#include <algorithm>
#include <utility>

#include "core/median.h"

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

/// The fit that most motions of the campaign reach, less a tenth: of the accepted ones that nothing
/// predicted, the median. It falls with the resolution and with the distance of the stations.
double CommonQuality(const std::vector<Pair>& pairs) {
  constexpr double kLess = 0.9;
  std::vector<double> qualities;
  for (const Pair& pair : pairs) {
    if (pair.accepted() && !pair.predicted) {
      qualities.push_back(pair.best()->verification.quality.value);
    }
  }
  if (qualities.empty()) return 0.0;
  return kLess * Median(std::move(qualities));
}

/// Whether only a fit speaks for the motion that is poorer than elsewhere in the campaign. Where
/// places look alike, false motions fit well enough to be believed alone, yet not as well as true
/// ones do.
bool FitsPoorly(const PairCandidate& motion, double common_quality,
                const VerificationOptions& options) {
  const VerificationResult& verification = motion.verification;
  return !IsSignificant(verification.consensus, verification.consensus_null, options) &&
         verification.quality.value < std::min(common_quality, options.sure_quality);
}

NetworkLink MakeLink(const Pair& pair, std::size_t pair_index, std::size_t candidate,
                     double common_quality, const VerificationOptions& options) {
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
  link.doubtful = candidate > 0 || !pair.accepted() || FitsPoorly(motion, common_quality, options);
  link.credibility = Credibility(verification, options.sure_conflict);
  return link;
}

}  // namespace

std::vector<CandidateLink> MakeCandidateLinks(const std::vector<Pair>& pairs,
                                              const VerificationOptions& options) {
  const double common_quality = CommonQuality(pairs);
  std::vector<CandidateLink> links;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    if (!pair.accepted() && !pair.doubtful()) continue;
    for (std::size_t c = 0; c < pair.candidates.size(); ++c) {
      if (pair.candidates[c].verification.verdict == Verdict::kRejected) continue;
      links.push_back({MakeLink(pair, p, c, common_quality, options), static_cast<int>(c)});
    }
  }
  return links;
}

}  // namespace backsight
