#include "pipeline/predicted_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.h"
#include "stages/matching.h"

namespace backsight {
namespace {

std::optional<double> LevelSigma(const StationSpec& a, const StationSpec& b) {
  if (!a.levelled || !b.levelled) return std::nullopt;
  return std::hypot(a.level_sigma_deg, b.level_sigma_deg) * std::numbers::pi / 180.0;
}

/// How well a chain of links predicts: some voxels, and what a degree makes of them.
Matrix6d PredictionInformation(double l) {
  constexpr double kTurn = 0.02;
  Vector6d sigma;
  sigma << kTurn, kTurn, kTurn, 3.0 * l, 3.0 * l, 3.0 * l;
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

int CountNear(const std::vector<Eigen::Vector3d>& source,
              const std::vector<Eigen::Vector3d>& target, const RigidTransform& motion,
              double radius_m) {
  return static_cast<int>(MatchPositions(source, target, motion, radius_m).size());
}

/// The most that the motion shifted aside gathers, over four directions.
int CountByChance(const std::vector<Eigen::Vector3d>& source,
                  const std::vector<Eigen::Vector3d>& target, const RigidTransform& motion,
                  double l) {
  int most = 0;
  for (const int axis : {0, 1}) {
    for (const double step : {-10.0 * l, 10.0 * l}) {
      RigidTransform aside = motion;
      aside.translation += step * Eigen::Vector3d::Unit(axis);
      most = std::max(most, CountNear(source, target, aside, 2.0 * l));
    }
  }
  return most;
}

void RegisterUnguarded(const Station& source, const Station& target, const SurveyOptions& options,
                       const ExecutionContext& context, const RigidTransform& predicted,
                       Pair* pair) {
  const double l = target.model.resolution_m();
  pair->coarse.status = CoarseResult::Status::kRegistered;
  pair->coarse.target_from_source = predicted;
  pair->coarse.information = PredictionInformation(l);
  const FineInput fine_input{{source.model, source.features.normals},
                             {target.model, target.features.normals},
                             predicted,
                             pair->coarse.information,
                             {}};
  FineOptions fine = options.fine;
  fine.activation = 0;  // there are no corresponding micro-structures to look near
  pair->fine = RefinePair(fine_input, fine, context);
  const auto q = KeypointPositions(source.model, source.features);
  const auto p = KeypointPositions(target.model, target.features);
  const RigidTransform& motion = pair->fine.target_from_source;
  pair->coarse.consensus = CountNear(q, p, motion, 2.0 * l);
  pair->coarse.consensus_null = CountByChance(q, p, motion, l);
  const bool credible = source.features.scanner_credible && target.features.scanner_credible;
  pair->verification = VerifyPair({source.model, target.model, credible, pair->coarse, pair->fine,
                                   LevelSigma(source.spec, target.spec)},
                                  options.verification);
}

}  // namespace

void RegisterPredictedPair(const std::vector<Station>& stations, const SurveyOptions& options,
                           const ExecutionContext& context, const RigidTransform& predicted,
                           Pair* pair) {
  const Station& source = stations[static_cast<std::size_t>(pair->source)];
  const Station& target = stations[static_cast<std::size_t>(pair->target)];
  try {
    context.CheckStop();
    RegisterUnguarded(source, target, options, context, predicted, pair);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    pair->fault = error.what();
    context.Warning("pair " + source.spec.id + " " + target.spec.id + ": " + pair->fault);
  }
}

}  // namespace backsight
