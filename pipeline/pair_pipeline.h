#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/station_pipeline.h"
#include "stages/coarse_registration.h"
#include "stages/fine_registration.h"
#include "stages/verification.h"

namespace backsight {

/// One motion of a pair, refined and verified. Frames: instrument.
struct PairCandidate {
  CoarseCandidate coarse;
  FineResult fine;
  VerificationResult verification;
  bool predicted = false;  ///< by the network or by a symmetry: no key points proposed it
};

/// One pair from features to verified motions. Frames: instrument.
struct Pair {
  int source = 0;
  int target = 0;
  int correspondences = 0;
  int consensus_null = 0;  ///< what chance alone reaches
  /// Best first; all but the first are its rivals. Empty where the coarse registration found none.
  std::vector<PairCandidate> candidates;
  bool predicted = false;        ///< from a predicted pose: no coarse registration
  std::string fault;             ///< empty: ran to its end, whatever the verification says
  bool short_of_memory = false;  ///< its fault is that memory ran out
  std::string further_fault;     ///< of an attempt after one whose result stands
  std::string digest;  ///< stands for all that led here (PairKey); empty where nothing is kept

  /// Null where there is none.
  const PairCandidate* best() const { return candidates.empty() ? nullptr : candidates.data(); }
  Verdict verdict() const;
  VerificationResult::Reason reason() const;
  bool accepted() const { return verdict() == Verdict::kAccepted; }
  bool doubtful() const { return verdict() == Verdict::kDoubtful; }
};

/// Pairs that were registered in full, by source and target.
using RegisteredPairs = std::map<std::pair<int, int>, Pair>;

/// Confidence of a motion for spanning trees: planes times overlap.
double LinkConfidence(const PairCandidate& candidate);

/// Indices of the pairs to be registered: every two usable stations but the excluded ones, the
/// earlier station as target.
std::vector<Pair> PlanPairs(const std::vector<Station>& stations, const PairSpec& spec);

/// Matching, coarse registration, then fine registration and verification of the best motion and
/// its rivals, which are compared on the refined clouds. A failure ends in the pair's `fault`.
void RegisterPair(const std::vector<Station>& stations, const SurveyOptions& options,
                  const ExecutionContext& context, Pair* pair);

/// A second try of a registered pair, for stations that walls surround: these tell the rotation,
/// and correspondences vote for translations (stages/aligned_hypotheses.h). What it finds competes
/// with the candidates that are there. About three times RegisterPair's time. False where it
/// failed; what was there stays then.
bool RegisterPairThoroughly(const std::vector<Station>& stations, const SurveyOptions& options,
                            const ExecutionContext& context, Pair* pair);

/// Fine registration and verification alone, from a predicted pose: one candidate. It is judged by
/// overlap, free space, and how far it moves from the prediction; its information holds next to
/// nothing of the prediction. About a third of RegisterPair's time.
void RegisterPairFrom(const std::vector<Station>& stations, const SurveyOptions& options,
                      const ExecutionContext& context,
                      const RigidTransform& predicted_target_from_source, Pair* pair);

/// Refines and verifies one more motion of a registered pair, and ranks it among the candidates
/// unless it is one of them, rejected, or contradicted more than the best. One that fits less
/// closely stays for the network to compare. False where it failed, which says nothing against what
/// the pair has.
bool AddMotion(const std::vector<Station>& stations, const SurveyOptions& options,
               const ExecutionContext& context, const RigidTransform& target_from_source,
               Pair* pair);

}  // namespace backsight
