#include "io/link_reasons.h"

#include <algorithm>
#include <utility>

namespace backsight {
namespace {

using Meaning = std::pair<std::string_view, std::string_view>;

constexpr Meaning kMeanings[] = {
    // Of the pair alone (stages/verification.h).
    {"not_registered", "too few key points of both agree on any motion"},
    {"not_significant", "neither common key points nor the fit of the surfaces prove the motion"},
    {"low_overlap", "too little of the two clouds would lie on each other"},
    {"fine_diverged", "refining led far away from its start"},
    {"tilted", "both are levelled, and their vertical axes would not be parallel"},
    {"free_space_conflict", "a scanner saw through surfaces that the other would put there"},
    {"far_from_start", "refining moved it further than its start can be in error"},
    {"undetermined",
     "no surface holds some direction, as along a street, on open ground or from one place, or "
     "nothing refined a predicted motion"},
    {"ambiguous", "several placements fit alike, as where a scene repeats or is symmetric"},
    {"contradicts_prior", "the priors of the project file rule it out"},
    // Of the network (graph/link_selection.h).
    {"contradicts_network", "the other links put its stations elsewhere"},
    {"rival_won", "another motion of the same two stations is used"},
    {"unconfirmed", "no loop of other links confirms it"},
    {"refuted_by_views", "it alone joined two parts that saw through each other's surfaces"},
    // Of pairs that were never tried (stages/pair_selection.h).
    {"unusable_station", "the scan of one of its stations cannot be used"},
    {"excluded", "the project file excludes it"},
    {"prior_too_far", "the priors put its stations out of each other's range"},
    {"redundant", "would overlap, but its stations have links enough"},
    {"no_overlap", "the poses predict too little overlap"},
    {"not_similar", "other pairs of the two parts were more alike"},
};

}  // namespace

std::string_view MeaningOfReason(std::string_view code) {
  const auto* const found =
      std::find_if(std::begin(kMeanings), std::end(kMeanings),
                   [&](const Meaning& meaning) { return meaning.first == code; });
  return found == std::end(kMeanings) ? std::string_view() : found->second;
}

}  // namespace backsight
