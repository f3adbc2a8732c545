#include "pipeline/symmetry_challenge.h"

#include <algorithm>

namespace backsight {
namespace {

constexpr std::size_t kMostSymmetries = 6;  // of one station

using Motions = std::vector<RigidTransform>;

void AddDistinct(const RigidTransform& motion, double resolution_m, Motions* motions) {
  const bool known = std::any_of(
      motions->begin(), motions->end(),
      [&](const RigidTransform& other) { return IsSameMotion(other, motion, resolution_m); });
  if (!known && motions->size() < kMostSymmetries) motions->push_back(motion);
}

/// Whether the clouds look alike under a motion, whatever else speaks against it as a registration.
bool IsLikeness(const VerificationResult& verification) {
  return verification.verdict != Verdict::kRejected ||
         verification.reason == VerificationResult::Reason::kNotSignificant;
}

/// Per station, in its instrument frame: motions under which its surroundings look the same, as its
/// ambiguous pairs have it.
std::vector<Motions> CollectSymmetries(const std::vector<Station>& stations,
                                       const std::vector<Pair>& pairs) {
  std::vector<Motions> symmetries(stations.size());
  for (const Pair& pair : pairs) {
    if (pair.reason() != VerificationResult::Reason::kAmbiguous) continue;
    const auto source = static_cast<std::size_t>(pair.source);
    const auto target = static_cast<std::size_t>(pair.target);
    const double l = stations[target].model.resolution_m();
    const RigidTransform& best = pair.candidates.front().fine.target_from_source;
    for (std::size_t c = 1; c < pair.candidates.size(); ++c) {
      const PairCandidate& rival = pair.candidates[c];
      if (!IsLikeness(rival.verification) ||
          IsClearlyBetter(pair.candidates.front().verification, rival.verification)) {
        continue;
      }
      const RigidTransform turn = rival.fine.target_from_source * best.Inverse();
      const RigidTransform turn_of_source = best.Inverse() * rival.fine.target_from_source;
      for (const RigidTransform& motion : {turn, turn.Inverse()}) {
        AddDistinct(motion, l, &symmetries[target]);
      }
      for (const RigidTransform& motion : {turn_of_source, turn_of_source.Inverse()}) {
        AddDistinct(motion, l, &symmetries[source]);
      }
    }
  }
  return symmetries;
}

}  // namespace

void ChallengeSymmetries(const PairUnits& units, std::vector<Pair>* pairs) {
  const std::vector<Motions> symmetries = CollectSymmetries(units.stations(), *pairs);
  units.context().ParallelFor(pairs->size(), [&](std::size_t i) {
    Pair& pair = (*pairs)[i];
    if (!pair.accepted()) return;
    const RigidTransform best = pair.best()->fine.target_from_source;
    Motions rivals;
    for (const RigidTransform& turn : symmetries[static_cast<std::size_t>(pair.target)]) {
      rivals.push_back(turn * best);
    }
    for (const RigidTransform& turn : symmetries[static_cast<std::size_t>(pair.source)]) {
      rivals.push_back(best * turn);
    }
    if (!rivals.empty()) units.Challenge(std::move(rivals), &pair);
  });
}

}  // namespace backsight
