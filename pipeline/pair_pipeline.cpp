#include "pipeline/pair_pipeline.h"

#include <algorithm>
#include <numbers>

#include "core/error.h"
#include "pipeline/candidate_ranking.h"
#include "pipeline/coarse_input.h"
#include "pipeline/pair_clouds.h"
#include "pipeline/pair_prospects.h"
#include "stages/aligned_hypotheses.h"
#include "stages/matching.h"
#include "stages/station_priors.h"

namespace backsight {
namespace {

/// Refines and verifies one motion.
PairCandidate MakeCandidate(const PairClouds& clouds, CoarseCandidate coarse,
                            std::vector<Eigen::Vector3d> structure_points,
                            std::optional<int> consensus, int consensus_null,
                            const SurveyOptions& options, const ExecutionContext& context) {
  PairCandidate candidate;
  FineInput fine_input{clouds.source,       clouds.target,
                       clouds.target_index, coarse.target_from_source,
                       coarse.information,  std::move(structure_points)};
  const auto planes = clouds.target_prepared.Planes(clouds.target, options.fine);
  fine_input.target_planes = planes.get();
  if (options.fine.surfaces) {
    fine_input.source_surfaces = &clouds.source_prepared.Surfaces(clouds.source);
  }
  candidate.fine = RefinePair(fine_input, options.fine, context);
  candidate.verification =
      VerifyPair({clouds.source, clouds.target, clouds.source_index, clouds.target_index,
                  coarse.target_from_source, coarse.information, consensus, consensus_null,
                  candidate.fine, clouds.level_sigma_rad},
                 options.verification);
  candidate.coarse = std::move(coarse);
  return candidate;
}

/// Rejects a motion that the priors of both stations rule out.
void CheckPriors(const Station& source, const Station& target, PairCandidate* candidate) {
  if (!source.spec.prior || !target.spec.prior) return;
  const RigidTransform motion = target.model.StationFromInstrument() *
                                candidate->fine.target_from_source *
                                source.model.StationFromInstrument().Inverse();
  VerificationResult& verification = candidate->verification;
  if (verification.verdict == Verdict::kRejected ||
      !ContradictsPriors(*source.spec.prior, *target.spec.prior, motion,
                         target.model.resolution_m())) {
    return;
  }
  verification.verdict = Verdict::kRejected;
  verification.reason = VerificationResult::Reason::kContradictsPrior;
}

/// Whether the refinement of `a` would end where that of `b` does.
bool IsSameStart(const RigidTransform& a, const RigidTransform& b, double resolution_m) {
  constexpr double kNearAngle = 0.5 * std::numbers::pi / 180.0;
  return (a.translation - b.translation).norm() < 0.5 * resolution_m &&
         RotationAngle(a.rotation, b.rotation) < kNearAngle;
}

/// Refines and verifies the coarse candidates that are not there yet.
void AddCandidates(const Station& source, const Station& target, const PairClouds& clouds,
                   const CoarseInput& input, CoarseResult coarse, const SurveyOptions& options,
                   const ExecutionContext& context, Pair* pair) {
  pair->consensus_null = coarse.consensus_null;
  if (coarse.candidates.empty()) return;
  const auto kept_for_all = clouds.target_prepared.Planes(clouds.target, options.fine);
  for (CoarseCandidate& candidate : coarse.candidates) {
    const bool known = std::any_of(
        pair->candidates.begin(), pair->candidates.end(), [&](const PairCandidate& other) {
          return IsSameStart(other.coarse.target_from_source, candidate.target_from_source,
                             input.resolution_m);
        });
    if (known) continue;
    std::vector<Eigen::Vector3d> structure_points;
    for (const std::uint32_t row : candidate.inliers) {
      structure_points.push_back(input.correspondences.target[row]);
    }
    const int consensus = candidate.consensus;
    pair->candidates.push_back(MakeCandidate(clouds, std::move(candidate),
                                             std::move(structure_points), consensus,
                                             coarse.consensus_null, options, context));
    CheckPriors(source, target, &pair->candidates.back());
  }
}

/// A motion that many key points support and that scanners contradict nevertheless: typical of the
/// wrong bay of a facade or the wrong end of a hall. The true motion may have been crowded out.
bool IsSuspicious(const Pair& pair, const VerificationOptions& options) {
  const PairCandidate* best = pair.best();
  return best != nullptr && IsSignificant(best->coarse.consensus, pair.consensus_null, options) &&
         best->verification.worst_conflict() >= options.sure_conflict;
}

/// Several times as many correspondences, edges and hypotheses.
CoarseOptions Thorough(CoarseOptions options) {
  options.nodes = 3 * options.nodes;
  options.edges_per_node *= 2;
  options.hypotheses *= 5;
  return options;
}

/// For votes, which false correspondences disturb less than they do RGN.
MatchingOptions MoreNeighbors(MatchingOptions options) {
  options.neighbors *= 5;
  return options;
}

void RegisterUnguarded(const Station& source, const Station& target, const SurveyOptions& options,
                       const ExecutionContext& context, Pair* pair) {
  const PairClouds clouds(source, target);
  const CoarseInput input = MakeCoarseInput(source, target, clouds, options, context);
  pair->correspondences = static_cast<int>(input.correspondences.size());
  AddCandidates(source, target, clouds, input, RegisterCoarse(input, options.coarse, context),
                options, context, pair);
  RankCandidates(input.resolution_m, &pair->candidates);
  if (!IsSuspicious(*pair, options.verification)) return;
  AddCandidates(source, target, clouds, input,
                RegisterCoarse(input, Thorough(options.coarse), context), options, context, pair);
  RankCandidates(input.resolution_m, &pair->candidates);
}

void VoteUnguarded(const Station& source, const Station& target, const SurveyOptions& options,
                   const ExecutionContext& context, Pair* pair) {
  const PairClouds clouds(source, target);
  CoarseInput input = MakeCoarseInput(source, target, clouds, options, context);
  input.rotations =
      AlignedRotations(clouds.source, clouds.target, clouds.level_sigma_rad.has_value());
  if (input.rotations.empty()) return;
  input.ballots = MatchStations(source.model, source.features, target.model, target.features,
                                MoreNeighbors(options.matching));
  const bool suspicious = IsSuspicious(*pair, options.verification);
  AddCandidates(
      source, target, clouds, input,
      RegisterCoarse(input, suspicious ? Thorough(options.coarse) : options.coarse, context),
      options, context, pair);
  RankCandidates(input.resolution_m, &pair->candidates);
}

/// Refines and verifies a motion that no correspondences have proposed.
PairCandidate MakeFromMotion(const Station& source, const Station& target,
                             const SurveyOptions& options, const ExecutionContext& context,
                             const RigidTransform& motion) {
  const PairClouds clouds(source, target);
  const double l = target.model.resolution_m();
  CoarseCandidate start;
  start.target_from_source = motion;
  // A prior so weak (10 l, 5 deg) that it only keeps the solution defined.
  constexpr double kTurnSigma = 5.0 * std::numbers::pi / 180.0;
  start.information.diagonal() << Eigen::Vector3d::Constant(1.0 / (kTurnSigma * kTurnSigma)),
      Eigen::Vector3d::Constant(1.0 / (100.0 * l * l));
  const Correspondences near =
      MatchPositions(KeypointPositions(source.model, source.features),
                     KeypointPositions(target.model, target.features), motion, 4.0 * l);
  PairCandidate candidate =
      MakeCandidate(clouds, std::move(start), near.target, std::nullopt, 0, options, context);
  CheckPriors(source, target, &candidate);
  candidate.predicted = true;
  return candidate;
}

/// Runs a pair's registration; what goes wrong ends in its `fault`.
template <class Body>
void Guard(const std::vector<Station>& stations, const ExecutionContext& context, Pair* pair,
           Body body) {
  const Station& source = stations[static_cast<std::size_t>(pair->source)];
  const Station& target = stations[static_cast<std::size_t>(pair->target)];
  try {
    context.CheckStop();
    body(source, target);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::bad_alloc&) {  // the caller may find more, or says so
    pair->fault = kShortOfMemory;
    pair->short_of_memory = true;
  } catch (const std::exception& error) {
    pair->fault = error.what();
    context.Warning("pair " + source.spec.id + " " + target.spec.id + ": " + pair->fault);
  }
}

}  // namespace

double LinkConfidence(const PairCandidate& candidate) {
  return (1.0 + candidate.fine.planes) * candidate.verification.overlap;
}

std::vector<Pair> PlanPairs(const std::vector<Station>& stations, const PairSpec& spec) {
  std::vector<Pair> pairs;
  for (const PairProspect& prospect : ListProspects(stations, spec)) {
    if (prospect.excluded) continue;
    Pair& pair = pairs.emplace_back();
    pair.source = prospect.source;
    pair.target = prospect.target;
  }
  return pairs;
}

Verdict Pair::verdict() const {
  if (!fault.empty() || candidates.empty()) return Verdict::kRejected;
  return candidates.front().verification.verdict;
}

VerificationResult::Reason Pair::reason() const {
  return candidates.empty() ? VerificationResult::Reason::kNotRegistered
                            : candidates.front().verification.reason;
}

void RegisterPair(const std::vector<Station>& stations, const SurveyOptions& options,
                  const ExecutionContext& context, Pair* pair) {
  Guard(stations, context, pair, [&](const Station& source, const Station& target) {
    RegisterUnguarded(source, target, options, context, pair);
  });
}

bool RegisterPairThoroughly(const std::vector<Station>& stations, const SurveyOptions& options,
                            const ExecutionContext& context, Pair* pair) {
  Pair attempt = *pair;
  Guard(stations, context, &attempt, [&](const Station& source, const Station& target) {
    VoteUnguarded(source, target, options, context, &attempt);
  });
  const bool whole = attempt.fault.empty();
  // What failed the second time does not take back what was found the first.
  if (whole || pair->best() == nullptr) {
    *pair = std::move(attempt);
  } else {
    pair->short_of_memory = attempt.short_of_memory;
    pair->further_fault = attempt.fault;
  }
  return whole;
}

void RegisterPairFrom(const std::vector<Station>& stations, const SurveyOptions& options,
                      const ExecutionContext& context,
                      const RigidTransform& predicted_target_from_source, Pair* pair) {
  pair->predicted = true;
  Guard(stations, context, pair, [&](const Station& source, const Station& target) {
    pair->candidates.push_back(
        MakeFromMotion(source, target, options, context, predicted_target_from_source));
  });
}

bool AddMotion(const std::vector<Station>& stations, const SurveyOptions& options,
               const ExecutionContext& context, const RigidTransform& target_from_source,
               Pair* pair) {
  Pair attempt;
  attempt.source = pair->source;
  attempt.target = pair->target;
  RegisterPairFrom(stations, options, context, target_from_source, &attempt);
  pair->short_of_memory = attempt.short_of_memory;
  if (!attempt.fault.empty()) pair->further_fault = attempt.fault;
  if (attempt.candidates.empty()) return attempt.fault.empty();
  PairCandidate& candidate = attempt.candidates.front();
  if (candidate.verification.verdict == Verdict::kRejected) return true;
  if (!pair->candidates.empty() &&
      IsContradictedMore(candidate.verification, pair->candidates.front().verification)) {
    return true;
  }
  pair->candidates.push_back(std::move(candidate));
  RankCandidates(stations[static_cast<std::size_t>(pair->target)].model.resolution_m(),
                 &pair->candidates);
  return true;
}

}  // namespace backsight
