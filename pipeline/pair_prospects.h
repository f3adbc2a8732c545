#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/survey_project.h"
#include "pipeline/station_pipeline.h"
#include "stages/pair_selection.h"

namespace backsight {

/// What a project and two stations themselves say of their pair.
class PairRules {
 public:
  explicit PairRules(const PairSpec& spec);

  /// The pair of two usable stations; the later one is its source.
  PairProspect ProspectOf(const std::vector<Station>& stations, std::size_t source,
                          std::size_t target) const;

 private:
  using IdPairs = std::set<std::pair<std::string, std::string>>;
  IdPairs included_;  // in both orders
  IdPairs excluded_;
};

/// Those of all pairs of usable stations, by target, then source.
std::vector<PairProspect> ListProspects(const std::vector<Station>& stations, const PairSpec& spec);

}  // namespace backsight
