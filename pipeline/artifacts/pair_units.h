#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/pair_pipeline.h"
#include "stages/pair_selection.h"

namespace backsight {

/// What one attempt at a pair does, and from what.
struct PairAttempt {
  std::string_view method;              ///< "full", "predicted", "thorough", "symmetries"
  std::vector<RigidTransform> motions;  ///< target_from_source, proposed by others
};

/// Attempts at pairs as units of work: what the store holds is not computed again, what was
/// computed without a fault is stored. Safe to use from several threads.
class PairUnits {
 public:
  /// All must outlive it. `limit_s`: of one attempt; 0: none.
  PairUnits(const std::vector<Station>& stations, const SurveyOptions& options,
            const ExecutionContext& context, const ArtifactStore& store, double limit_s = 0.0)
      : stations_(stations),
        options_(options),
        context_(context),
        store_(store),
        limit_s_(limit_s) {}

  /// `predicted`: of PairMethod::kPredicted. False where the attempt failed, so that nothing of it
  /// is stored; a pair that has a motion from before keeps it then, and has no `fault`.
  bool Register(PairMethod method, const std::optional<RigidTransform>& predicted,
                Pair* pair) const;

  /// The same if the store holds the result; false, and nothing done, where it does not.
  bool Replay(PairMethod method, const std::optional<RigidTransform>& predicted, Pair* pair) const;

  /// Has an accepted pair compete with the motions, until one makes it doubtful. False where that
  /// failed; the pair is as it was then, but for `short_of_memory`.
  bool Challenge(std::vector<RigidTransform> motions, Pair* pair) const;

  const std::vector<Station>& stations() const { return stations_; }
  const SurveyOptions& options() const { return options_; }
  const ExecutionContext& context() const { return context_; }
  const ArtifactStore& store() const { return store_; }

 private:
  /// Says whether it ran to its end.
  using Compute = std::function<bool(const ExecutionContext&, Pair*)>;
  ArtifactKey KeyOf(const PairAttempt& attempt, const Pair& pair) const;
  std::string NameOf(const PairAttempt& attempt, const Pair& pair) const;
  bool Restore(const PairAttempt& attempt, Pair* pair) const;
  bool Run(const PairAttempt& attempt, const Compute& compute, Pair* pair) const;
  bool ComputeGuarded(const Compute& compute, Pair* pair) const;

  const std::vector<Station>& stations_;
  const SurveyOptions& options_;
  const ExecutionContext& context_;
  const ArtifactStore& store_;
  double limit_s_;
};

}  // namespace backsight
