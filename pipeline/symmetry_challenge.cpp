#include "pipeline/symmetry_challenge.h"

#include <fmt/format.h>

#include <algorithm>

#include "stages/same_motion.h"

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

/// The motions that a pair's stations make possible besides its own.
Motions RivalsOf(const Pair& pair, const std::vector<Motions>& symmetries) {
  Motions rivals;
  const RigidTransform& best = pair.best()->fine.target_from_source;
  for (const RigidTransform& turn : symmetries[static_cast<std::size_t>(pair.target)]) {
    rivals.push_back(turn * best);
  }
  for (const RigidTransform& turn : symmetries[static_cast<std::size_t>(pair.source)]) {
    rivals.push_back(best * turn);
  }
  return rivals;
}

/// Once more, alone; a pair that cannot be challenged is not believed.
void ChallengeAlone(const PairUnits& units, Motions rivals, Pair* pair) {
  if (units.Challenge(std::move(rivals), pair)) return;
  MarkAmbiguous(&pair->candidates.front().verification);
  pair->digest += " unchallenged";
  units.context().Warning(fmt::format(
      "pair {} {}: it could not be compared with what its stations' symmetries make possible, and "
      "is doubtful therefore",
      units.stations()[static_cast<std::size_t>(pair->source)].spec.id,
      units.stations()[static_cast<std::size_t>(pair->target)].spec.id));
}

}  // namespace

void ChallengeSymmetries(const PairUnits& units, std::vector<Pair>* pairs) {
  const std::vector<Motions> symmetries = CollectSymmetries(units.stations(), *pairs);
  std::vector<Motions> rivals(pairs->size());
  std::vector<char> failed(pairs->size(), 0);
  units.context().ParallelFor(pairs->size(), [&](std::size_t i) {
    Pair& pair = (*pairs)[i];
    if (!pair.accepted()) return;
    rivals[i] = RivalsOf(pair, symmetries);
    if (!rivals[i].empty() && !units.Challenge(rivals[i], &pair)) failed[i] = 1;
  });
  for (std::size_t i = 0; i < pairs->size(); ++i) {
    if (failed[i] != 0) ChallengeAlone(units, std::move(rivals[i]), &(*pairs)[i]);
  }
}

}  // namespace backsight
