#pragma once

#include <vector>

#include "core/execution.h"
#include "io/artifact_store.h"
#include "io/survey_project.h"
#include "pipeline/pair_discovery.h"
#include "pipeline/survey_options.h"

namespace backsight {

/// One of several tasks that share the pairs of a campaign: those whose index modulo `count` is
/// `index`.
struct PairShard {
  int index = 0;
  int count = 1;
};

inline constexpr int kMostPairShards = 200;

/// Into how many tasks the pairs of a campaign are divided; 0 where the network decides which pairs
/// are registered (IsExhaustive is false), so that they cannot be told beforehand.
int CountPairShards(const SurveyProject& project, const SurveyOptions& options);

/// Registers the shard's pairs in full, as the run of an exhaustive campaign does first, and stores
/// what comes of it; what is stored already is not done again. Second tries and registrations from
/// predicted poses, which need the network of all pairs, are left to the run. Only the stations of
/// the shard are loaded. Returns how many pairs could not be registered.
int RegisterPairShard(const SurveyProject& project, const SurveyOptions& options,
                      const PairShard& shard, const ExecutionContext& context,
                      const ArtifactStore& store);

/// Keeps what a discovery needs next for RegisterBatchShard.
void StoreBatch(const std::vector<PairTask>& batch, const SurveyProject& project,
                const SurveyOptions& options, const ExecutionContext& context,
                const ArtifactStore& store);

/// Makes the shard's attempts of the stored batch; as RegisterPairShard. Throws InputError where
/// none is stored for this project.
int RegisterBatchShard(const SurveyProject& project, const SurveyOptions& options,
                       const PairShard& shard, const ExecutionContext& context,
                       const ArtifactStore& store);

}  // namespace backsight
