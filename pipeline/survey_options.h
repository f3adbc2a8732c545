#pragma once

#include <vector>

#include "core/option_visitor.h"
#include "stages/coarse_registration.h"
#include "stages/features.h"
#include "stages/fine_registration.h"
#include "stages/georeferencing.h"
#include "stages/ingest.h"
#include "stages/matching.h"
#include "stages/moving_objects.h"
#include "stages/network_refinement.h"
#include "stages/network_solution.h"
#include "stages/pair_ranking.h"
#include "stages/pair_selection.h"
#include "stages/placement_check.h"
#include "stages/verification.h"

namespace backsight {

/// The options of every stage, with their defaults.
struct SurveyOptions {
  IngestOptions ingest;
  FeatureOptions features;
  PairSelectionOptions pair_selection;
  PairRankingOptions pair_ranking;
  MatchingOptions matching;
  CoarseOptions coarse;
  FineOptions fine;
  VerificationOptions verification;
  NetworkOptions network;
  PlacementCheckOptions placement_check;
  NetworkRefinementOptions refinement;
  GeoreferencingOptions georeferencing;
  MovingObjectOptions moving_objects;
};

/// The sections of the project file, in the order of the method. They refer to `options`, which
/// must outlive them.
std::vector<OptionSection> OptionSections(SurveyOptions& options);

}  // namespace backsight
