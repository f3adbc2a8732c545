#include "pipeline/candidate_ranking.h"

#include <algorithm>
#include <utility>

#include "stages/same_motion.h"

namespace backsight {
namespace {

/// Whether `a`, the same motion as `b` but for some decimetres, is the better refined of the two.
bool IsBetterRefined(const PairCandidate& a, const PairCandidate& b) {
  return a.verification.verdict <= b.verification.verdict &&
         a.verification.quality.value > b.verification.quality.value &&
         !IsContradictedMore(a.verification, b.verification);
}

/// Motions from different starts may have been refined to the same one: the better refined stays,
/// the first of equals.
void EraseRepeats(double resolution_m, std::vector<PairCandidate>* candidates) {
  std::vector<PairCandidate> distinct;
  for (PairCandidate& candidate : *candidates) {
    const auto same =
        std::find_if(distinct.begin(), distinct.end(), [&](const PairCandidate& other) {
          return IsSameMotion(other.fine.target_from_source, candidate.fine.target_from_source,
                              resolution_m);
        });
    if (same == distinct.end()) {
      distinct.push_back(std::move(candidate));
    } else if (IsBetterRefined(candidate, *same)) {
      *same = std::move(candidate);
    }
  }
  *candidates = std::move(distinct);
}

}  // namespace

void RankCandidates(double resolution_m, std::vector<PairCandidate>* candidates) {
  const auto rejected = [](const PairCandidate& c) {
    return c.verification.verdict == Verdict::kRejected;
  };
  std::stable_sort(candidates->begin(), candidates->end(),
                   [&](const PairCandidate& a, const PairCandidate& b) {
                     if (rejected(a) != rejected(b)) return rejected(b);
                     return a.verification.conflict.value < b.verification.conflict.value;
                   });
  EraseRepeats(resolution_m, candidates);
  if (candidates->empty()) return;
  std::size_t best = 0;
  for (std::size_t i = 1; i < candidates->size(); ++i) {
    if (rejected((*candidates)[i])) break;
    const VerificationResult& rival = (*candidates)[i].verification;
    const bool contradicted = IsContradictedMore(rival, (*candidates)[0].verification);
    if (!contradicted && rival.quality.value > (*candidates)[best].verification.quality.value) {
      best = i;
    }
  }
  std::rotate(candidates->begin(), candidates->begin() + static_cast<std::ptrdiff_t>(best),
              candidates->begin() + static_cast<std::ptrdiff_t>(best) + 1);
  for (std::size_t i = 1; i < candidates->size(); ++i) {
    if (rejected((*candidates)[i])) break;
    if (!IsClearlyBetter((*candidates)[0].verification, (*candidates)[i].verification)) {
      MarkAmbiguous(&(*candidates)[0].verification);
      MarkAmbiguous(&(*candidates)[i].verification);
    }
  }
}

}  // namespace backsight
