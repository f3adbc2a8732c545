#include "pipeline/run_summary.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/distance_records.h"
#include "pipeline/ground_records.h"
#include "pipeline/link_records.h"
#include "pipeline/run_verdict.h"
#include "pipeline/run_warnings.h"
#include "pipeline/unlinked_stations.h"
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

/// Pairs that were none, because a scan could not be used: whoever counts pairs finds all of them.
void AddPairsOfUnusable(const std::vector<Station>& stations, std::vector<LinkRecord>* links) {
  for (std::size_t t = 0; t < stations.size(); ++t) {
    for (std::size_t s = t + 1; s < stations.size(); ++s) {
      if (stations[s].usable() && stations[t].usable()) continue;
      links->push_back(MakeSkippedRecord(
          stations, {static_cast<int>(s), static_cast<int>(t), "unusable_station"}));
    }
  }
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
    record.reason = DescribeUnlinked(links, station.spec.id);
    return record;
  }
  record.status = StationStatus::kRegistered;
  record.survey_from_station = network.survey_from_station[index];
  record.covariance = network.covariance[index];
  record.ground = MakeGroundPose(ground, index);
  return record;
}

Completion CompletionOf(const PairDiscovery& discovery, const Network& network) {
  const auto failed = std::count_if(
      discovery.pairs.begin(), discovery.pairs.end(),
      [](const Pair& pair) { return !pair.fault.empty() || !pair.further_fault.empty(); });
  const bool any_link = std::any_of(network.candidates.begin(), network.candidates.end(),
                                    [](const NetworkCandidate& c) { return c.used(); });
  return {static_cast<int>(failed), !any_link || network.solution.poses.converged};
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
  AddPairsOfUnusable(stations, &run.links);
  for (std::size_t s = 0; s < stations.size(); ++s) {
    run.scans.push_back(stations[s].record);
    run.scans.back().moving = moving.Of(s).points;
    run.poses.push_back(MakePoseRecord(stations[s], network, ground, s, run.links));
  }
  run.outputs = outputs;
  run.survey_points = static_cast<int>(project.control.size());
  run.georeference = MakeGeoreferenceRecords(project, ground);
  run.gates = JudgeGates(project.gates, run.poses, run.georeference);
  run.components = MakeComponentRecords(stations, network);
  run.closures = MakeClosureRecords(stations, discovery.pairs, network);
  run.network = NetworkFigures(discovery, network);
  run.distances = MakeDistanceRecord(stations, distances);
  const Completion completion = CompletionOf(discovery, network);
  Judge(completion, &run);
  AddWarnings(project, stations, discovery, network, ground, &run);
  if (!completion.converged) {
    run.warnings.push_back("the network adjustment did not converge; its poses are provisional");
  }
  return run;
}

}  // namespace backsight
