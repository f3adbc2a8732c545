#include "pipeline/run_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "pipeline/survey_pipeline.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

std::string FineStatusName(FineResult::Status status) {
  switch (status) {
    case FineResult::Status::kRefined:
      return "refined";
    case FineResult::Status::kRefinedOnSurfaces:
      return "refined_on_surfaces";
    case FineResult::Status::kWeak:
      return "weak";
    case FineResult::Status::kTooFewPlanes:
      return "too_few_planes";
    case FineResult::Status::kDiverged:
      return "diverged";
  }
  return "";
}

LinkRecord MakeLinkRecord(const std::vector<Station>& stations, const Network& network,
                          const Pair& pair, int link) {
  const Station& source = stations[static_cast<std::size_t>(pair.source)];
  const Station& target = stations[static_cast<std::size_t>(pair.target)];
  LinkRecord record;
  record.source = source.spec.id;
  record.target = target.spec.id;
  record.correspondences = pair.correspondences;
  record.consensus_null = pair.consensus_null;
  if (!pair.fault.empty()) {
    record.reason = pair.fault;
    return record;
  }
  record.status = pair.accepted() ? LinkStatus::kAccepted : LinkStatus::kRejected;
  record.reason = ToString(pair.reason());
  const PairCandidate* best = pair.best();
  if (best == nullptr) return record;
  record.consensus = best->coarse.consensus;

  const auto in_station_frames = [&](const RigidTransform& motion) {
    return target.model.StationFromInstrument() * motion *
           source.model.StationFromInstrument().Inverse();
  };
  record.coarse = in_station_frames(best->coarse.target_from_source);
  record.fine = in_station_frames(best->fine.target_from_source);
  record.fine_status = FineStatusName(best->fine.status);
  record.overlap = best->verification.overlap;
  record.planes = best->fine.planes;
  record.rms_m = best->fine.rms_m;
  record.weakest_sigma_m = best->fine.weakest_sigma_m;
  record.iterations = best->fine.iterations;
  if (link < 0) return record;

  const auto l = static_cast<std::size_t>(link);
  const NetworkResult& solution = network.solution;
  record.network_weight = solution.poses.weights[l];
  record.network_residual_m = solution.residuals[l].tail<3>().norm();
  record.network_residual_deg = solution.residuals[l].head<3>().norm() * 180.0 / std::numbers::pi;
  record.loop_controlled = solution.loop_controlled[l];
  if (record.network_weight == 0.0) {
    record.status = LinkStatus::kRejected;
    record.reason = "contradicts_network";
  }
  return record;
}

LinkRecord MakeSkippedRecord(const std::vector<Station>& stations, const SkippedPair& skipped) {
  LinkRecord record;
  record.source = stations[static_cast<std::size_t>(skipped.source)].spec.id;
  record.target = stations[static_cast<std::size_t>(skipped.target)].spec.id;
  record.status = LinkStatus::kSkipped;
  record.reason = skipped.reason;
  return record;
}

int CountAccepted(const std::vector<LinkRecord>& links, const std::string& station) {
  return static_cast<int>(std::count_if(links.begin(), links.end(), [&](const LinkRecord& link) {
    return link.status == LinkStatus::kAccepted &&
           (link.source == station || link.target == station);
  }));
}

PoseRecord MakePoseRecord(const Station& station, const Network& network, std::size_t index,
                          const std::vector<LinkRecord>& links) {
  PoseRecord record;
  record.station = station.spec.id;
  if (!station.usable()) {
    record.status = StationStatus::kUnreadable;
    record.reason = station.fault;
    return record;
  }
  record.component = network.component[index];
  record.link_count = CountAccepted(links, station.spec.id);
  if (record.component < 0) {
    record.reason = "no accepted link to any other station";
    return record;
  }
  record.status = StationStatus::kRegistered;
  record.survey_from_station = network.survey_from_station[index];
  record.covariance = network.covariance[index];
  return record;
}

int CountRegistered(const std::vector<PoseRecord>& poses, int component) {
  return static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const PoseRecord& pose) {
    return pose.status == StationStatus::kRegistered &&
           (component < 0 || pose.component == component);
  }));
}

std::vector<GateRecord> JudgeGates(const GateSpec& gates, const std::vector<PoseRecord>& poses) {
  std::vector<GateRecord> judged;
  if (gates.max_station_sigma_mm) {
    double worst_mm = 0.0;
    for (const PoseRecord& pose : poses) {
      if (const auto sigma = SigmaOf(pose)) {
        worst_mm = std::max(worst_mm, 1000.0 * sigma->worst_position_m);
      }
    }
    judged.push_back({"max_station_sigma_mm", fmt::format("{:g} mm", *gates.max_station_sigma_mm),
                      fmt::format("{:.2f} mm", worst_mm), worst_mm <= *gates.max_station_sigma_mm});
  }
  if (gates.require_all_stations) {
    const int placed = CountRegistered(poses, 0);
    judged.push_back({"require_all_stations", fmt::format("{} in one network", poses.size()),
                      fmt::format("{}", placed), placed == static_cast<int>(poses.size())});
  }
  return judged;
}

/// Sets verdict and exit code. A failed gate outranks a partial result: it was asked for.
void Judge(RunRecord* run) {
  const int all = static_cast<int>(run->poses.size());
  const int placed = CountRegistered(run->poses, 0);
  const int usable = static_cast<int>(std::count_if(
      run->poses.begin(), run->poses.end(),
      [](const PoseRecord& pose) { return pose.status != StationStatus::kUnreadable; }));
  const auto failed = std::find_if(run->gates.begin(), run->gates.end(),
                                   [](const GateRecord& gate) { return !gate.passed; });
  if (usable < 2) {
    run->exit_code = kNoUsableInput;
    run->verdict = fmt::format("No usable input: {} of {} scans could be read.", usable, all);
  } else if (failed != run->gates.end()) {
    run->exit_code = kGateFailed;
    run->verdict = fmt::format("Gate {} failed: {} (limit {}). {} of {} stations placed.",
                               failed->name, failed->value, failed->limit, placed, all);
  } else if (placed < all) {
    run->exit_code = kPartial;
    run->verdict = fmt::format("Partial: {} of {} stations placed in one network.", placed, all);
  } else {
    run->exit_code = kComplete;
    run->verdict = fmt::format("Complete: all {} stations placed in one network.", all);
  }
}

void AddWarnings(RunRecord* run) {
  for (const PoseRecord& pose : run->poses) {
    if (pose.status != StationStatus::kRegistered) {
      run->warnings.push_back(fmt::format("station {}: {}", pose.station, pose.reason));
    } else if (pose.component > 0) {
      run->warnings.push_back(
          fmt::format("station {} is in component {}, which nothing connects with the main network",
                      pose.station, pose.component + 1));
    }
  }
  for (const LinkRecord& link : run->links) {
    if (link.reason == "contradicts_network") {
      run->warnings.push_back(
          fmt::format("link {} - {} contradicts the network by {:.3f} m and was removed",
                      link.source, link.target, link.network_residual_m));
    }
    if (link.status == LinkStatus::kAccepted && !link.loop_controlled.value_or(false)) {
      run->warnings.push_back(
          fmt::format("link {} - {} is uncontrolled: no loop of other links checks it", link.source,
                      link.target));
    }
    if (link.status == LinkStatus::kAccepted && link.fine_status != "refined" &&
        link.fine_status != "refined_on_surfaces") {
      run->warnings.push_back(fmt::format("link {} - {}: fine registration ended as {}",
                                          link.source, link.target, link.fine_status));
    }
  }
}

}  // namespace

RunRecord SummarizeRun(const SurveyProject& project, const std::vector<Station>& stations,
                       const PairDiscovery& discovery, const Network& network,
                       const std::vector<OutputRecord>& outputs) {
  RunRecord run;
  run.project_name = project.name;
  run.version = kVersion;
  for (std::size_t p = 0; p < discovery.pairs.size(); ++p) {
    run.links.push_back(
        MakeLinkRecord(stations, network, discovery.pairs[p], network.link_of_pair[p]));
  }
  for (const SkippedPair& skipped : discovery.skipped) {
    run.links.push_back(MakeSkippedRecord(stations, skipped));
  }
  for (std::size_t s = 0; s < stations.size(); ++s) {
    run.scans.push_back(stations[s].record);
    run.poses.push_back(MakePoseRecord(stations[s], network, s, run.links));
  }
  run.outputs = outputs;
  run.gates = JudgeGates(project.gates, run.poses);
  const NetworkResult& solution = network.solution;
  run.network = {{"sigma_factor", solution.sigma_factor},
                 {"redundancy", static_cast<double>(solution.redundancy)},
                 {"robust_rounds", static_cast<double>(solution.poses.rounds)}};
  Judge(&run);
  AddWarnings(&run);
  if (!solution.poses.weights.empty() && !solution.poses.converged) {
    run.warnings.push_back("the network adjustment did not converge; its poses are provisional");
    if (run.exit_code == kComplete) run.exit_code = kPartial;
  }
  return run;
}

}  // namespace backsight
