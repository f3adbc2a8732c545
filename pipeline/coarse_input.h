#pragma once

#include "pipeline/pair_clouds.h"
#include "pipeline/survey_options.h"
#include "stages/coarse_registration.h"

namespace backsight {

/// What the coarse registration of a pair starts from: correspondences, motions proposed by plans,
/// symmetries, and how the clouds judge a motion. `clouds` and `context` must outlive it.
CoarseInput MakeCoarseInput(const Station& source, const Station& target, const PairClouds& clouds,
                            const SurveyOptions& options, const ExecutionContext& context);

}  // namespace backsight
