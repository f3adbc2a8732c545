#pragma once

#include <string>
#include <vector>

#include "pipeline/station_pipeline.h"
#include "stages/coarse_registration.h"
#include "stages/fine_registration.h"
#include "stages/verification.h"

namespace backsight {

/// One pair from features to a verified transform. Frames: instrument.
struct Pair {
  int source = 0;
  int target = 0;
  int correspondences = 0;
  CoarseResult coarse;
  FineResult fine;
  VerificationResult verification;
  std::string fault;  ///< empty: ran to its end, whatever the verification says

  bool accepted() const { return fault.empty() && verification.accepted(); }
};

/// Indices of the pairs to be registered: every two usable stations but the excluded ones, the
/// earlier station as target.
std::vector<Pair> PlanPairs(const std::vector<Station>& stations, const PairSpec& spec);

/// Matching, coarse registration, fine registration, verification. A failure ends in the pair's
/// `fault`.
void RegisterPair(const std::vector<Station>& stations, const SurveyOptions& options,
                  const ExecutionContext& context, Pair* pair);

/// All pairs, side by side.
void RegisterPairs(const std::vector<Station>& stations, const SurveyOptions& options,
                   const ExecutionContext& context, std::vector<Pair>* pairs);

}  // namespace backsight
