#include "pipeline/pair_rankings.h"

#include <fmt/format.h>

#include <string>

#include "core/archive.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/load_artifact.h"
#include "stages/pair_ranking.h"

namespace backsight {
namespace {

/// What RankPairs sets of every candidate, in their order.
struct Ranking {
  std::vector<double> similarity;
  std::vector<char> unmatched;
};

template <class Archive>
void Transfer(Archive& archive, Ranking& ranking) {
  archive(ranking.similarity, ranking.unmatched);
}

std::vector<RankedStation> RankedStations(const std::vector<Station>& stations) {
  std::vector<RankedStation> ranked(stations.size());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const Station& station = stations[s];
    if (!station.usable()) continue;
    ranked[s] = {&station.model, &station.features, station.spec.levelled, station.record.extent_m,
                 station.spec.prior};
  }
  return ranked;
}

Ranking RankAll(const PairUnits& units, std::vector<PairProspect> candidates) {
  RankPairs(RankedStations(units.stations()), units.options().pair_ranking, units.context(),
            &candidates);
  Ranking ranking;
  for (const PairProspect& candidate : candidates) {
    ranking.similarity.push_back(candidate.similarity);
    ranking.unmatched.push_back(candidate.unmatched ? 1 : 0);
  }
  return ranking;
}

/// Similarities of the candidates `which`, in their order.
std::vector<double> MatchAll(const PairUnits& units, const std::vector<std::size_t>& which,
                             std::vector<PairProspect> candidates) {
  MatchPairs(RankedStations(units.stations()), units.options().pair_ranking, units.context(), which,
             &candidates);
  std::vector<double> similarity;
  similarity.reserve(which.size());
  for (const std::size_t i : which) similarity.push_back(candidates[i].similarity);
  return similarity;
}

}  // namespace

void RankOnce(const PairUnits& units, std::vector<PairProspect>* candidates) {
  std::vector<char> may_be_tried;
  for (const PairProspect& candidate : *candidates) {
    may_be_tried.push_back(!candidate.excluded && !candidate.too_far ? 1 : 0);
  }
  const ArtifactKey key =
      RankingKey({units.options(), units.context().seed()}, units.stations(), may_be_tried);
  const Ranking ranking = Once(units.store(), kRankingName, key, ToBytes<Ranking>,
                               FromBytes<Ranking>, [&] { return RankAll(units, *candidates); });
  for (std::size_t i = 0; i < candidates->size(); ++i) {
    (*candidates)[i].similarity = ranking.similarity.at(i);
    (*candidates)[i].unmatched = ranking.unmatched.at(i) != 0;
  }
}

void MatchOnce(const PairUnits& units, const std::vector<std::size_t>& which, int round,
               std::vector<PairProspect>* candidates) {
  using Similarities = std::vector<double>;
  const ArtifactKey key =
      FurtherRankingKey({units.options(), units.context().seed()}, units.stations(), which);
  const Similarities similarity =
      Once(units.store(), fmt::format("{}_{}", kRankingName, round), key, ToBytes<Similarities>,
           FromBytes<Similarities>, [&] { return MatchAll(units, which, *candidates); });
  for (std::size_t k = 0; k < which.size(); ++k) {
    (*candidates)[which[k]].similarity = similarity.at(k);
    (*candidates)[which[k]].unmatched = false;
  }
}

}  // namespace backsight
