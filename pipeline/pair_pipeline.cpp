#include "pipeline/pair_pipeline.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "stages/matching.h"

namespace backsight {
namespace {

bool IsExcluded(const PairSpec& spec, const std::string& a, const std::string& b) {
  return std::any_of(spec.exclude.begin(), spec.exclude.end(), [&](const auto& pair) {
    return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
  });
}

/// Standard deviation of both levellings together; none unless both stations are levelled.
std::optional<double> LevelSigma(const StationSpec& a, const StationSpec& b) {
  if (!a.levelled || !b.levelled) return std::nullopt;
  return std::hypot(a.level_sigma_deg, b.level_sigma_deg) * std::numbers::pi / 180.0;
}

void RegisterUnguarded(const Station& source, const Station& target, const SurveyOptions& options,
                       const ExecutionContext& context, Pair* pair) {
  CoarseInput coarse_input;
  coarse_input.correspondences =
      MatchStations(source.model, source.features, target.model, target.features, options.matching);
  coarse_input.resolution_m = target.model.resolution_m();
  coarse_input.source_keypoints = KeypointPositions(source.model, source.features);
  coarse_input.target_keypoints = KeypointPositions(target.model, target.features);
  coarse_input.seed = DeriveSeed(context.seed(), "pair " + source.spec.id + " " + target.spec.id);
  const Surface source_surface{source.model, source.features.normals};
  const Surface target_surface{target.model, target.features.normals};
  const bool credible = source.features.scanner_credible && target.features.scanner_credible;
  coarse_input.cloud_score = [&](const RigidTransform& target_from_source) {
    return CloudScore(source_surface, target_surface, target_from_source, credible) +
           CloudScore(target_surface, source_surface, target_from_source.Inverse(), credible);
  };
  pair->correspondences = static_cast<int>(coarse_input.correspondences.size());
  pair->coarse = RegisterCoarse(coarse_input, options.coarse, context);

  if (pair->coarse.status == CoarseResult::Status::kRegistered) {
    FineInput fine_input{source_surface,
                         target_surface,
                         pair->coarse.target_from_source,
                         pair->coarse.information,
                         {}};
    for (const std::uint32_t row : pair->coarse.inliers) {
      fine_input.structure_points.push_back(coarse_input.correspondences.target[row]);
    }
    pair->fine = RefinePair(fine_input, options.fine, context);
  }
  pair->verification = VerifyPair({source.model, target.model, credible, pair->coarse, pair->fine,
                                   LevelSigma(source.spec, target.spec)},
                                  options.verification);
}

}  // namespace

std::vector<Pair> PlanPairs(const std::vector<Station>& stations, const PairSpec& spec) {
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < stations.size(); ++t) {
    for (std::size_t s = t + 1; s < stations.size(); ++s) {
      if (!stations[s].usable() || !stations[t].usable()) continue;
      if (IsExcluded(spec, stations[s].spec.id, stations[t].spec.id)) continue;
      Pair pair;
      pair.source = static_cast<int>(s);
      pair.target = static_cast<int>(t);
      pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

void RegisterPair(const std::vector<Station>& stations, const SurveyOptions& options,
                  const ExecutionContext& context, Pair* pair) {
  const Station& source = stations[static_cast<std::size_t>(pair->source)];
  const Station& target = stations[static_cast<std::size_t>(pair->target)];
  try {
    context.CheckStop();
    RegisterUnguarded(source, target, options, context, pair);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    pair->fault = error.what();
    context.Warning("pair " + source.spec.id + " " + target.spec.id + ": " + pair->fault);
  }
}

void RegisterPairs(const std::vector<Station>& stations, const SurveyOptions& options,
                   const ExecutionContext& context, std::vector<Pair>* pairs) {
  std::atomic<std::size_t> done = 0;
  context.Progress("pairs", 0, pairs->size());
  context.ParallelFor(pairs->size(), [&](std::size_t i) {
    RegisterPair(stations, options, context, &(*pairs)[i]);
    context.Progress("pairs", ++done, pairs->size());
  });
}

}  // namespace backsight
