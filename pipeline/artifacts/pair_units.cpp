#include "pipeline/artifacts/pair_units.h"

#include <new>

#include "pipeline/artifacts/fault_record.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/artifacts/pair_artifact.h"

namespace backsight {
namespace {

std::string_view MethodName(PairMethod method) {
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

PairAttempt AttemptOf(PairMethod method, const std::optional<RigidTransform>& predicted) {
  PairAttempt attempt{MethodName(method), {}};
  if (predicted) attempt.motions.push_back(*predicted);
  return attempt;
}

}  // namespace

bool PairUnits::Replay(PairMethod method, const std::optional<RigidTransform>& predicted,
                       Pair* pair) const {
  return store_.keeps() && Restore(AttemptOf(method, predicted), pair);
}

bool PairUnits::Register(PairMethod method, const std::optional<RigidTransform>& predicted,
                         Pair* pair) const {
  return Run(
      AttemptOf(method, predicted),
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

bool PairUnits::Challenge(std::vector<RigidTransform> motions, Pair* pair) const {
  const PairAttempt attempt{"symmetries", std::move(motions)};
  Pair challenged = *pair;
  const bool whole = Run(
      attempt,
      [&](const ExecutionContext& context, Pair* result) {
        for (const RigidTransform& motion : attempt.motions) {
          if (!result->accepted()) break;
          if (!AddMotion(stations_, options_, context, motion, result)) return false;
        }
        return true;
      },
      &challenged);
  if (whole) {
    *pair = std::move(challenged);
  } else {
    pair->short_of_memory = challenged.short_of_memory;
  }
  return whole;
}

ArtifactKey PairUnits::KeyOf(const PairAttempt& attempt, const Pair& pair) const {
  return PairKey({options_, context_.seed()}, attempt.method,
                 stations_[static_cast<std::size_t>(pair.source)],
                 stations_[static_cast<std::size_t>(pair.target)], attempt.motions, pair.digest);
}

std::string PairUnits::NameOf(const PairAttempt& attempt, const Pair& pair) const {
  return PairArtifactName(stations_[static_cast<std::size_t>(pair.source)],
                          stations_[static_cast<std::size_t>(pair.target)], attempt.method);
}

bool PairUnits::Restore(const PairAttempt& attempt, Pair* pair) const {
  const ArtifactKey key = KeyOf(attempt, *pair);
  auto restored = LoadArtifact(store_, NameOf(attempt, *pair), key, [&](std::string_view bytes) {
    Pair stored;
    stored.source = pair->source;
    stored.target = pair->target;
    RestorePair(bytes, &stored);
    return stored;
  });
  if (!restored) return false;
  *pair = *std::move(restored);
  pair->digest = key.Digest();
  return true;
}

bool PairUnits::Run(const PairAttempt& attempt, const Compute& compute, Pair* pair) const {
  // What follows a fault depends on more than a key says.
  if (!store_.keeps() || !pair->fault.empty()) return ComputeGuarded(compute, pair);
  if (Restore(attempt, pair)) return true;
  const ArtifactKey key = KeyOf(attempt, *pair);
  const std::string name = NameOf(attempt, *pair);
  ForgetFault(store_, name);
  if (!ComputeGuarded(compute, pair)) {
    if (!pair->fault.empty()) KeepFault(store_, name, key, pair->fault);
    return false;
  }
  store_.Store(name, key, PairBytes(*pair));
  pair->digest = key.Digest();
  return true;
}

/// A pair that memory did not suffice for is as it was, but for `short_of_memory`.
bool PairUnits::ComputeGuarded(const Compute& compute, Pair* pair) const {
  try {
    const Pair before = *pair;
    const bool whole = compute(context_.WithTimeLimit(limit_s_), pair);
    if (pair->short_of_memory) {
      *pair = before;
      pair->short_of_memory = true;
    }
    return whole;
  } catch (const std::bad_alloc&) {
    pair->short_of_memory = true;
    return false;
  }
}

}  // namespace backsight
