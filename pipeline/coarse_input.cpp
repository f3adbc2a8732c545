#include "pipeline/coarse_input.h"

#include "core/random.h"
#include "pipeline/plan_proposals.h"
#include "stages/matching.h"
#include "stages/structure_images.h"
#include "stages/surface_refinement.h"
#include "stages/verification.h"

namespace backsight {

CoarseInput MakeCoarseInput(const Station& source, const Station& target, const PairClouds& clouds,
                            const SurveyOptions& options, const ExecutionContext& context) {
  CoarseInput input;
  input.correspondences =
      MatchStations(source.model, source.features, target.model, target.features, options.matching);
  input.resolution_m = target.model.resolution_m();
  input.source_keypoints = KeypointPositions(source.model, source.features);
  input.target_keypoints = KeypointPositions(target.model, target.features);
  input.seed = DeriveSeed(context.seed(), "pair " + source.spec.id + " " + target.spec.id);
  if (clouds.level_sigma_rad) input.max_tilt_rad = LargestTilt(*clouds.level_sigma_rad);
  input.proposals = ProposeByPlans(source, target);
  input.source_symmetries = source.symmetries;
  input.target_symmetries = target.symmetries;
  // What follows takes the time of a pair: a stop need not wait for its end.
  input.cloud_score = [&clouds, &context](const RigidTransform& motion) {
    context.CheckStop();
    return clouds.Score(clouds.source_index.sieve, clouds.target_index.sieve, 1.0, motion);
  };
  input.cloud_score_bound = [&clouds, &context](const RigidTransform& motion) {
    context.CheckStop();
    return clouds.ScoreBound(clouds.source_index.sieve, clouds.target_index.sieve, motion);
  };
  input.full_cloud_score = [&clouds, &context](const RigidTransform& motion) {
    context.CheckStop();
    return clouds.Score(clouds.source_index.sample, clouds.target_index.sample, 0.0, motion);
  };
  // Where no scanner can contradict a motion, every motion scores; half as well is no rival.
  const bool blind = !clouds.source.scanner_credible && !clouds.target.scanner_credible;
  input.least_rival_share = blind ? 0.5 : 0.0;
  input.least_rival_score = 0.5 * options.verification.min_overlap;
  input.structure_images = [&clouds, &context](const RigidTransform& motion) {
    context.CheckStop();
    return FindStructureImages(clouds.source, clouds.source_index, clouds.target,
                               clouds.target_index, motion);
  };
  input.cloud_refine = [&clouds, &context](const RigidTransform& motion) {
    context.CheckStop();
    return RefineRoughly(clouds.source, clouds.target, clouds.target_index, motion);
  };
  return input;
}

}  // namespace backsight
