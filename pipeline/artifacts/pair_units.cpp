#include "pipeline/artifacts/pair_units.h"

#include "core/archive.h"
#include "pipeline/artifacts/pair_artifact.h"

namespace backsight {
namespace {

std::string_view NameOf(PairMethod method) {
  switch (method) {
    case PairMethod::kFull:
      return "full";
    case PairMethod::kPredicted:
      return "predicted";
    case PairMethod::kThorough:
      return "thorough";
  }
  return "";
}

}  // namespace

void PairUnits::Register(PairMethod method, const std::optional<RigidTransform>& predicted,
                         Pair* pair) const {
  PairAttempt attempt{NameOf(method), {}};
  if (predicted) attempt.motions.push_back(*predicted);
  Run(
      attempt,
      [&](const ExecutionContext& context, Pair* result) {
        if (method == PairMethod::kThorough) {
          return RegisterPairThoroughly(stations_, options_, context, result);
        }
        // A prediction competes with what correspondences found; it must not hide their doubts.
        if (method == PairMethod::kPredicted && result->best() != nullptr) {
          return AddMotion(stations_, options_, context, predicted.value(), result);
        }
        if (method == PairMethod::kPredicted) {
          RegisterPairFrom(stations_, options_, context, predicted.value(), result);
        } else {
          RegisterPair(stations_, options_, context, result);
        }
        return result->fault.empty();
      },
      pair);
}

void PairUnits::Challenge(std::vector<RigidTransform> motions, Pair* pair) const {
  const PairAttempt attempt{"symmetries", std::move(motions)};
  Run(
      attempt,
      [&](const ExecutionContext& context, Pair* result) {
        bool whole = true;
        for (const RigidTransform& motion : attempt.motions) {
          if (!result->accepted()) break;
          whole = AddMotion(stations_, options_, context, motion, result) && whole;
        }
        return whole;
      },
      pair);
}

void PairUnits::Run(const PairAttempt& attempt, const Compute& compute, Pair* pair) const {
  const Station& source = stations_[static_cast<std::size_t>(pair->source)];
  const Station& target = stations_[static_cast<std::size_t>(pair->target)];
  if (!store_.keeps()) {
    compute(context_.WithTimeLimit(limit_s_), pair);
    return;
  }
  const ArtifactKey key = PairKey({options_, context_.seed()}, attempt.method, source, target,
                                  attempt.motions, pair->digest);
  const std::string name = PairArtifactName(source.spec.id, target.spec.id, attempt.method);
  std::string bytes;
  if (store_.Load(name, key, &bytes)) {
    RestorePair(bytes, pair);
  } else if (compute(context_.WithTimeLimit(limit_s_), pair)) {
    store_.Store(name, key, PairBytes(*pair));
  } else {
    return;
  }
  pair->digest = key.Digest();
}

}  // namespace backsight
