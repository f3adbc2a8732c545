#include "stages/pair_ranking.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "stages/pair_prematch.h"
#include "stages/station_signature.h"

namespace backsight {
namespace {

std::size_t At(int index) { return static_cast<std::size_t>(index); }

bool MayBeTried(const PairProspect& pair) { return !pair.excluded && !pair.too_far; }

std::vector<double> SignatureScores(const std::vector<RankedStation>& stations, int words,
                                    const std::vector<PairProspect>& candidates,
                                    const ExecutionContext& context) {
  std::vector<const StationFeatures*> features;
  features.reserve(stations.size());
  static const StationFeatures kNone;
  for (const RankedStation& station : stations) {
    features.push_back(station.features != nullptr ? station.features : &kNone);
  }
  const std::vector<StationSignature> signatures =
      ComputeSignatures(features, {.words = words}, context);
  std::vector<double> scores(candidates.size());
  context.ParallelFor(
      candidates.size(),
      [&](std::size_t i) {
        const PairProspect& pair = candidates[i];
        scores[i] =
            static_cast<double>(signatures[At(pair.source)].dot(signatures[At(pair.target)]));
      },
      /*grain=*/256);
  return scores;
}

/// Candidates among the `most` best of either of their stations, ascending.
std::vector<std::size_t> BestOfEachStation(std::size_t stations, int most,
                                           const std::vector<PairProspect>& candidates,
                                           const std::vector<double>& scores) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (MayBeTried(candidates[i])) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  std::vector<int> taken(stations, 0);
  std::vector<std::size_t> chosen;
  for (const std::size_t i : order) {
    int& source = taken[At(candidates[i].source)];
    int& target = taken[At(candidates[i].target)];
    if (std::min(source, target) >= most) continue;
    ++source, ++target;
    chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// The stations that the chosen pairs take part in.
std::vector<char> Concerned(std::size_t stations, const std::vector<PairProspect>& candidates,
                            const std::vector<std::size_t>& chosen) {
  std::vector<char> concerned(stations, 0);
  for (const std::size_t i : chosen) {
    concerned[At(candidates[i].source)] = concerned[At(candidates[i].target)] = 1;
  }
  return concerned;
}

/// Of every station; 0 where it has no plan.
std::vector<double> PlanCells(const std::vector<RankedStation>& stations,
                              const ExecutionContext& context) {
  std::vector<double> cells_m(stations.size(), 0.0);
  context.ParallelFor(stations.size(), [&](std::size_t s) {
    const RankedStation& station = stations[s];
    if (station.model == nullptr || !station.levelled) return;
    cells_m[s] = PlanCellFor(*station.model, *station.features);
  });
  return cells_m;
}

std::vector<double> PrematchScores(const std::vector<RankedStation>& stations,
                                   const PairRankingOptions& options,
                                   const std::vector<PairProspect>& candidates,
                                   const std::vector<std::size_t>& chosen,
                                   const ExecutionContext& context) {
  PrematchOptions prematch;
  prematch.keypoints = options.prematch_keypoints;
  const std::vector<double> cells_m = PlanCells(stations, context);
  const double largest_m =
      cells_m.empty() ? 0.0 : *std::max_element(cells_m.begin(), cells_m.end());
  const std::vector<char> concerned = Concerned(stations.size(), candidates, chosen);
  std::vector<StationSketch> sketches(stations.size());
  context.ParallelFor(stations.size(), [&](std::size_t s) {
    const RankedStation& station = stations[s];
    if (station.model == nullptr || concerned[s] == 0) return;
    sketches[s] =
        SketchStation(*station.model, *station.features, {cells_m[s], largest_m}, prematch);
  });
  std::vector<double> scores(chosen.size());
  std::atomic<std::size_t> done = 0;
  context.Progress("pair ranking", 0, chosen.size());
  context.ParallelFor(
      chosen.size(),
      [&](std::size_t k) {
        context.CheckStop();
        const PairProspect& pair = candidates[chosen[k]];
        scores[k] =
            PrematchPair(sketches[At(pair.source)], sketches[At(pair.target)], prematch, context);
        context.Progress("pair ranking", ++done, chosen.size());
      },
      /*grain=*/16);
  return scores;
}

/// What the priors say for a pair: 0 where they say nothing, up to 1 for stations at one place.
double PriorNearness(const RankedStation& a, const RankedStation& b) {
  if (!a.prior || !b.prior) return 0.0;
  const double distance_m =
      (a.prior->survey_from_station.translation - b.prior->survey_from_station.translation).norm();
  const double range_m = std::max(a.range_m, b.range_m);
  return std::exp(-distance_m / std::max(range_m, 1e-3));
}

/// Larger than any score of a match or a signature.
constexpr double kTier = 1000.0;

/// What priors place nearby comes first.
void PutPriorsFirst(const std::vector<RankedStation>& stations, PairProspect* pair) {
  pair->similarity +=
      2.0 * kTier * PriorNearness(stations[At(pair->source)], stations[At(pair->target)]);
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, PairRankingOptions& options) {
  visitor.Integer("words", options.words, "1", 2, 4096,
                  "words of the vocabulary by which stations are compared as a whole");
  visitor.Integer("prematch_per_station", options.prematch_per_station, "1", 0, 100000,
                  "most similar stations of each that are matched cheaply before any registration");
  visitor.Integer("prematch_keypoints", options.prematch_keypoints, "1", 10, 100000,
                  "key points of each station in the cheap match");
}

void RankPairs(const std::vector<RankedStation>& stations, const PairRankingOptions& options,
               const ExecutionContext& context, std::vector<PairProspect>* candidates) {
  const std::vector<double> signature =
      SignatureScores(stations, options.words, *candidates, context);
  const std::vector<std::size_t> chosen =
      BestOfEachStation(stations.size(), options.prematch_per_station, *candidates, signature);
  for (std::size_t i = 0; i < candidates->size(); ++i) {
    PairProspect& pair = (*candidates)[i];
    pair.similarity = signature[i] - kTier;
    pair.unmatched = true;
    PutPriorsFirst(stations, &pair);
  }
  MatchPairs(stations, options, context, chosen, candidates);
}

void MatchPairs(const std::vector<RankedStation>& stations, const PairRankingOptions& options,
                const ExecutionContext& context, const std::vector<std::size_t>& which,
                std::vector<PairProspect>* candidates) {
  const std::vector<double> match = PrematchScores(stations, options, *candidates, which, context);
  for (std::size_t k = 0; k < which.size(); ++k) {
    PairProspect& pair = (*candidates)[which[k]];
    pair.similarity = match[k];
    pair.unmatched = false;
    PutPriorsFirst(stations, &pair);
  }
}

}  // namespace backsight
