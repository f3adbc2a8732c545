#include "pipeline/run_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/distance_records.h"
#include "pipeline/ground_records.h"
#include "pipeline/link_records.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

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

PoseRecord MakePoseRecord(const Station& station, const Network& network,
                          const GeoreferencedNetwork& ground, std::size_t index,
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
    record.reason =
        "no accepted link to any other station" + DescribeDoubtful(links, station.spec.id);
    return record;
  }
  record.status = StationStatus::kRegistered;
  record.survey_from_station = network.survey_from_station[index];
  record.covariance = network.covariance[index];
  record.ground = MakeGroundPose(ground, index);
  return record;
}

int CountRegistered(const std::vector<PoseRecord>& poses, int component) {
  return static_cast<int>(std::count_if(poses.begin(), poses.end(), [&](const PoseRecord& pose) {
    return pose.status == StationStatus::kRegistered &&
           (component < 0 || pose.component == component);
  }));
}

/// Of its place on the ground where control gives it one.
std::optional<PoseSigma> SigmaOnGround(const PoseRecord& pose) {
  if (!pose.ground) return SigmaOf(pose);
  return SigmaOf(pose.ground->enu_from_station, pose.ground->covariance);
}

/// The component with the largest error; no check points at all are a failure, too.
GateRecord JudgeCheckPoints(double limit_mm, const std::vector<GeoreferenceRecord>& georeference) {
  CheckRecord worst;
  for (const GeoreferenceRecord& record : georeference) {
    if (record.check.points == 0) continue;
    if (worst.points == 0 || record.check.rmse_3d_m > worst.rmse_3d_m) worst = record.check;
  }
  const double rmse_mm = 1000.0 * worst.rmse_3d_m;
  return {"max_check_rmse_mm", fmt::format("{:g} mm, 3D", limit_mm),
          worst.points == 0 ? "no check points"
                            : fmt::format("{:.2f} mm, n = {}", rmse_mm, worst.points),
          worst.points > 0 && rmse_mm <= limit_mm};
}

std::vector<GateRecord> JudgeGates(const GateSpec& gates, const std::vector<PoseRecord>& poses,
                                   const std::vector<GeoreferenceRecord>& georeference) {
  std::vector<GateRecord> judged;
  for (const GeoreferenceRecord& record : georeference) {
    if (record.status != "contradictory") continue;
    judged.push_back({"control_agrees", "residuals that the sigmas explain",
                      fmt::format("residuals of control {:.1f} times as large as its sigmas allow",
                                  std::sqrt(record.variance_factor)),
                      false});
  }
  if (gates.max_check_rmse_mm) {
    judged.push_back(JudgeCheckPoints(*gates.max_check_rmse_mm, georeference));
  }
  if (gates.max_station_sigma_mm) {
    double worst_mm = 0.0;
    for (const PoseRecord& pose : poses) {
      if (const auto sigma = SigmaOnGround(pose)) {
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

/// False if there is control and it does not place the main network.
bool IsOnGround(const RunRecord& run) {
  return run.georeference.empty() || run.georeference.front().placed();
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
  } else if (!IsOnGround(*run)) {
    run->exit_code = kPartial;
    run->verdict = fmt::format(
        "Partial: {} of {} stations placed in one network, which control does not tie to the "
        "ground.",
        placed, all);
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
      run->warnings.push_back(fmt::format(
          "station {} is in component {}, which nothing connects with the main network{}",
          pose.station, ComponentNumber(pose.component),
          DescribeDoubtful(run->links, pose.station)));
    }
  }
  for (const LinkRecord& link : run->links) {
    if (link.reason == "contradicts_network") {
      run->warnings.push_back(
          fmt::format("link {} - {} contradicts the network by {:.3f} m and was removed",
                      link.source, link.target, link.network_residual_m));
    }
    if (link.reason == "refuted_by_views") {
      run->warnings.push_back(fmt::format(
          "link {} - {} was the only one between two parts of the network, whose stations saw "
          "through each other's surfaces; the parts were left apart",
          link.source, link.target));
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

/// Stations that saw through each other's surfaces, and those that could stand in two ways.
void AddPlacementWarnings(const std::vector<Station>& stations, const Network& network,
                          RunRecord* run) {
  const auto id = [&](int station) { return stations[static_cast<std::size_t>(station)].spec.id; };
  for (const PlacementConflict& pair : network.check.conflicts) {
    run->warnings.push_back(fmt::format(
        "stations {} and {} contradict each other: {:.0f} % of the surfaces in view were seen "
        "through; look at both in the cross sections",
        id(pair.a), id(pair.b), 100.0 * pair.conflict));
  }
  for (const Ambiguity& ambiguity : network.solution.ambiguities) {
    std::string names;
    for (const int station : ambiguity.stations) {
      names += (names.empty() ? "" : ", ") + id(station);
    }
    run->warnings.push_back(fmt::format(
        "station(s) {} could stand in two ways, {:.2f} m and {:.1f} deg apart, between which the "
        "scans do not decide; they were left apart",
        names, ambiguity.shift_m, ambiguity.turn_deg));
  }
}

/// The refinement was accepted for what it did to all pairs together; a pair may have lost by it.
void AddHeldOutWarnings(const std::vector<Station>& stations, const Network& network,
                        RunRecord* run) {
  constexpr double kSignificant = 3.0;  // by chance one pair in 700
  for (const NetworkPart& part : network.parts) {
    if (part.refinement.status != NetworkRefinementResult::Status::kRefined) continue;
    const auto id = [&](int place) {
      const int station = part.stations[static_cast<std::size_t>(place)];
      return stations[static_cast<std::size_t>(station)].spec.id;
    };
    for (const HeldOutPair& pair : part.refinement.held_out) {
      if (!pair.change.IsWorse(kSignificant)) continue;
      run->warnings.push_back(fmt::format(
          "stations {} and {} fit worse since the planes of all stations were adjusted: {:.2f} mm "
          "rms before, {:.2f} mm after on {} planes that took no part",
          id(pair.a), id(pair.b), 1000.0 * pair.rms_before, 1000.0 * pair.rms_after, pair.planes));
    }
  }
}

std::vector<std::pair<std::string, double>> NetworkFigures(const PairDiscovery& discovery,
                                                           const Network& network) {
  const NetworkResult& solution = network.solution;
  return {{"sigma_factor", solution.sigma_factor},
          {"cycle_sigma_factor", solution.cycle_sigma_factor},
          {"redundancy", static_cast<double>(solution.redundancy)},
          {"robust_rounds", static_cast<double>(solution.poses.rounds)},
          {"links_removed", static_cast<double>(solution.removed)},
          {"links_readmitted", static_cast<double>(solution.readmitted)},
          {"pairs_registered_in_full", static_cast<double>(discovery.full)},
          {"pairs_from_predicted_poses", static_cast<double>(discovery.predicted)},
          {"station_pairs_compared_in_place", static_cast<double>(network.check.pairs_compared)},
          {"station_pairs_in_conflict", static_cast<double>(network.check.conflicts.size())}};
}

}  // namespace

RunRecord SummarizeRun(const SurveyProject& project, const std::vector<Station>& stations,
                       const PairDiscovery& discovery, const Network& network,
                       const GeoreferencedNetwork& ground, const MovingPoints& moving,
                       const SurfaceDistances& distances,
                       const std::vector<OutputRecord>& outputs) {
  RunRecord run;
  run.project_name = project.name;
  run.version = kVersion;
  run.links = MakeLinkRecords(stations, discovery.pairs, network);
  for (const SkippedPair& skipped : discovery.skipped) {
    run.links.push_back(MakeSkippedRecord(stations, skipped));
  }
  for (std::size_t s = 0; s < stations.size(); ++s) {
    run.scans.push_back(stations[s].record);
    run.scans.back().moving = moving.Of(s).points;
    run.poses.push_back(MakePoseRecord(stations[s], network, ground, s, run.links));
  }
  run.outputs = outputs;
  run.georeference = MakeGeoreferenceRecords(project, ground);
  run.gates = JudgeGates(project.gates, run.poses, run.georeference);
  run.components = MakeComponentRecords(stations, network);
  run.closures = MakeClosureRecords(stations, discovery.pairs, network);
  run.network = NetworkFigures(discovery, network);
  run.distances = MakeDistanceRecord(stations, distances);
  Judge(&run);
  AddWarnings(&run);
  AddPlacementWarnings(stations, network, &run);
  AddHeldOutWarnings(stations, network, &run);
  for (std::string& warning : GroundWarnings(project, ground, run.georeference)) {
    run.warnings.push_back(std::move(warning));
  }
  for (std::string& warning : SightingWarnings(project, stations)) {
    run.warnings.push_back(std::move(warning));
  }
  const PoseGraphResult& poses = network.solution.poses;
  const bool any_link = std::any_of(network.candidates.begin(), network.candidates.end(),
                                    [](const NetworkCandidate& c) { return c.used(); });
  if (any_link && !poses.converged) {
    run.warnings.push_back("the network adjustment did not converge; its poses are provisional");
    if (run.exit_code == kComplete) run.exit_code = kPartial;
  }
  return run;
}

}  // namespace backsight
