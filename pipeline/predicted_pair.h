#pragma once

#include "pipeline/pair_pipeline.h"

namespace backsight {

/// Fine registration and verification of a pair from a pose that the network predicts, instrument
/// frames. Key points that lie closest to each other there stand in for descriptor matches, and
/// those that do so with the source put aside by ten voxels for what chance would give. A failure
/// ends in the pair's `fault`.
void RegisterPredictedPair(const std::vector<Station>& stations, const SurveyOptions& options,
                           const ExecutionContext& context, const RigidTransform& predicted,
                           Pair* pair);

}  // namespace backsight
