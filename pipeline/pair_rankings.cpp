#include "pipeline/pair_rankings.h"

#include <fmt/format.h>

#include <numeric>
#include <string>

#include "core/archive.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/load_artifact.h"
#include "stages/pair_ranking.h"

namespace backsight {
namespace {

/// What ranking says of the candidates `which`, in their order.
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

Ranking Extract(const std::vector<PairProspect>& candidates,
                const std::vector<std::size_t>& which) {
  Ranking ranking;
  for (const std::size_t i : which) {
    ranking.similarity.push_back(candidates[i].similarity);
    ranking.unmatched.push_back(candidates[i].unmatched ? 1 : 0);
  }
  return ranking;
}

/// Ranks the candidates `which` by `rank`, or as the store has it for the pairs `asked`, a mask.
template <class Rank>
void Restore(const PairUnits& units, const std::string& name, const std::vector<char>& asked,
             const std::vector<std::size_t>& which, Rank rank,
             std::vector<PairProspect>* candidates) {
  const ArtifactKey key =
      RankingKey({units.options(), units.context().seed()}, units.stations(), asked);
  const Ranking ranking = Once(units.store(), name, key, ToBytes<Ranking>, FromBytes<Ranking>, [&] {
    rank();
    return Extract(*candidates, which);
  });
  for (std::size_t k = 0; k < which.size(); ++k) {
    (*candidates)[which[k]].similarity = ranking.similarity.at(k);
    (*candidates)[which[k]].unmatched = ranking.unmatched.at(k) != 0;
  }
}

}  // namespace

void RankOnce(const PairUnits& units, std::vector<PairProspect>* candidates) {
  std::vector<char> may_be_tried;
  for (const PairProspect& candidate : *candidates) {
    may_be_tried.push_back(!candidate.excluded && !candidate.too_far ? 1 : 0);
  }
  std::vector<std::size_t> all(candidates->size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Restore(
      units, kRankingName, may_be_tried, all,
      [&] {
        RankPairs(RankedStations(units.stations()), units.options().pair_ranking, units.context(),
                  candidates);
      },
      candidates);
}

void MatchOnce(const PairUnits& units, const std::vector<std::size_t>& which, int round,
               std::vector<PairProspect>* candidates) {
  std::vector<char> asked(candidates->size(), 0);
  for (const std::size_t i : which) asked[i] = 1;
  Restore(
      units, fmt::format("{}_{}", kRankingName, round), asked, which,
      [&] {
        MatchPairs(RankedStations(units.stations()), units.options().pair_ranking, units.context(),
                   which, candidates);
      },
      candidates);
}

}  // namespace backsight
