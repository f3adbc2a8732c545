#include "pipeline/pair_prospects.h"

#include <algorithm>

#include "stages/station_priors.h"

namespace backsight {
namespace {

std::set<std::pair<std::string, std::string>> BothWays(
    const std::vector<std::pair<std::string, std::string>>& list) {
  std::set<std::pair<std::string, std::string>> both;
  for (const auto& [a, b] : list) both.emplace(a, b), both.emplace(b, a);
  return both;
}

}  // namespace

PairRules::PairRules(const PairSpec& spec)
    : included_(BothWays(spec.include)), excluded_(BothWays(spec.exclude)) {}

PairProspect PairRules::ProspectOf(const std::vector<Station>& stations, std::size_t source,
                                   std::size_t target) const {
  const Station& from = stations[source];
  const Station& to = stations[target];
  PairProspect prospect;
  prospect.source = static_cast<int>(source);
  prospect.target = static_cast<int>(target);
  prospect.required = included_.contains({from.spec.id, to.spec.id});
  prospect.excluded = excluded_.contains({from.spec.id, to.spec.id});
  prospect.too_far = from.spec.prior && to.spec.prior &&
                     ArePriorsTooFar(*from.spec.prior, *to.spec.prior,
                                     std::max(from.record.extent_m, to.record.extent_m));
  return prospect;
}

std::vector<PairProspect> ListProspects(const std::vector<Station>& stations,
                                        const PairSpec& spec) {
  const PairRules rules(spec);
  std::vector<PairProspect> prospects;
  for (std::size_t t = 0; t < stations.size(); ++t) {
    for (std::size_t s = t + 1; s < stations.size(); ++s) {
      if (!stations[s].usable() || !stations[t].usable()) continue;
      prospects.push_back(rules.ProspectOf(stations, s, t));
    }
  }
  return prospects;
}

}  // namespace backsight
