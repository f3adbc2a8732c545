#pragma once

#include <string>
#include <vector>

#include "io/artifact_store.h"
#include "io/survey_project.h"
#include "pipeline/run_stages.h"
#include "pipeline/survey_options.h"

namespace backsight {

/// A piece of work and whether it has to be done.
struct PlanItem {
  std::string unit;  ///< "station S1", "pair S2 S1 full", "network", "out/merged.las"
  ArtifactState::Kind state = ArtifactState::Kind::kMissing;
  std::string why;  ///< what changed, what is damaged, or what it depends on; may be empty
  /// Whether only a run can tell, which would read a scan for it; the state is then kOutdated.
  bool unsure = false;
  /// Whether the last run failed at it, as `why` says. A run tries again; nothing waits for it.
  bool failed = false;

  bool done() const { return state == ArtifactState::Kind::kUpToDate; }
};

/// What a run would do, as far as can be said without doing it: pairs that only a growing network
/// would propose are not in it.
struct RunPlan {
  std::vector<PlanItem> stations;
  std::vector<PlanItem> pairs;
  bool all_pairs = true;  ///< otherwise `pairs` are those that the stored network was made from
  std::vector<PlanItem> network;  ///< and what moved
  std::vector<PlanItem> outputs;

  bool done() const;
};

/// What a plan makes of units that the last run failed at.
enum class EarlierFaults {
  kStay,  ///< they fail again, and what follows stands without them
  kMend   ///< they are done this time, as far as room for it must be found
};

/// Compares what the store holds with the project. Reads no scans and writes nothing. `seed`: of
/// the run.
RunPlan MakeRunPlan(const SurveyProject& project, const SurveyOptions& options, std::uint64_t seed,
                    const std::string& out_directory, const ArtifactStore& store,
                    EarlierFaults faults = EarlierFaults::kStay);

/// Takes what comes after the last stage out of the plan, and puts in all that is to be done anew.
void Restrict(const StageRange& stages, RunPlan* plan);

/// How many are up to date.
std::size_t CountDone(const std::vector<PlanItem>& items);

/// "up to date", "missing", "outdated", "damaged", "not known", "failed".
std::string StateText(const PlanItem& item);

}  // namespace backsight
