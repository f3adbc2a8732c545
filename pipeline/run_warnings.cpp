#include "pipeline/run_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/html_table.h"
#include "pipeline/ground_records.h"
#include "pipeline/name_list.h"
#include "pipeline/unlinked_stations.h"

namespace backsight {
namespace {

void AddPoseWarnings(RunRecord* run) {
  for (const PoseRecord& pose : run->poses) {
    if (pose.status == StationStatus::kRegistered) continue;
    run->warnings.push_back(fmt::format("station {}: {}", pose.station, pose.reason));
  }
}

/// Stations that could stand in two ways: often the cause of parts that stand apart.
void AddAmbiguityWarnings(const std::vector<Station>& stations, const Network& network,
                          RunRecord* run) {
  for (const Ambiguity& ambiguity : network.solution.ambiguities) {
    std::vector<std::string> names;
    names.reserve(ambiguity.stations.size());
    for (const int station : ambiguity.stations) {
      names.push_back(stations[static_cast<std::size_t>(station)].spec.id);
    }
    run->warnings.push_back(fmt::format(
        "station(s) {} could stand in two ways, {:.2f} m and {:.1f} deg apart, between which the "
        "scans do not decide; they were left apart",
        fmt::join(names, ", "), ambiguity.shift_m, ambiguity.turn_deg));
  }
}

bool IsOnGround(const RunRecord& run, int component) {
  return std::any_of(run.georeference.begin(), run.georeference.end(),
                     [=](const auto& g) { return g.component == component && g.placed(); });
}

/// Parts of the network beside the main one.
void AddComponentWarnings(RunRecord* run) {
  std::map<int, std::vector<std::string>> stations;
  for (const PoseRecord& pose : run->poses) {
    if (pose.status != StationStatus::kRegistered || pose.component == 0) continue;
    stations[pose.component].push_back(pose.station);
  }
  for (const auto& [component, members] : stations) {
    run->warnings.push_back(
        fmt::format("component {} ({}) stands apart: no link joins it with other stations{}{}",
                    ComponentNumber(component), FirstNames(members),
                    IsOnGround(*run, component) ? "; control alone places it" : "",
                    DescribeGap(run->links, {members.begin(), members.end()})));
  }
}

/// What users often know and do not say, where it could place more stations.
void AddLevelHint(const SurveyProject& project, RunRecord* run) {
  const bool apart = std::any_of(run->poses.begin(), run->poses.end(), [](const PoseRecord& pose) {
    return pose.status == StationStatus::kNotRegistered || pose.component > 0;
  });
  const bool levelled = std::any_of(project.stations.begin(), project.stations.end(),
                                    [](const StationSpec& station) { return station.levelled; });
  if (!apart || levelled || project.stations.empty()) return;
  run->warnings.emplace_back(
      "no station is said to be levelled; where the instruments were, levelled: true in the "
      "project rules out placements at an angle, so that more stations can be placed");
}

void AddLinkWarnings(RunRecord* run) {
  for (const LinkRecord& link : run->links) {
    if (link.reason == "contradicts_network") {
      const std::string by =
          link.network_residual_m ? fmt::format(" by {:.3f} m", *link.network_residual_m) : "";
      run->warnings.push_back(fmt::format("link {} - {} contradicts the network{} and was removed",
                                          link.source, link.target, by));
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
        link.fine_status != "refined_on_surfaces" && link.fine_status != "weak") {
      run->warnings.push_back(fmt::format("link {} - {}: fine registration ended as {}",
                                          link.source, link.target, link.fine_status));
    }
  }
}

/// "D - T (24.1 mm; scanner's place 51.8 mm)": the sigmas of what the link knows least.
std::string DescribeWeakness(const LinkRecord& link) {
  constexpr double kOpen = 99.0;  // m: nothing holds it
  const double weakest_m = link.weakest_sigma_m.value_or(kOpen);
  std::string text =
      fmt::format("{} - {} ({}", link.source, link.target,
                  weakest_m < kOpen ? fmt::format("{:.1f} mm", 1000.0 * weakest_m) : "open");
  if (link.worst_place) {
    text += fmt::format("; scanner's place {:.1f} mm", 1000.0 * link.worst_place->sigma_m);
  }
  return text + ")";
}

/// Accepted links that leave one direction to the rest of the network, the weakest first.
void AddWeakLinkWarning(RunRecord* run) {
  std::vector<const LinkRecord*> links;
  for (const LinkRecord& link : run->links) {
    if (link.status == LinkStatus::kAccepted && link.fine_status == "weak") links.push_back(&link);
  }
  if (links.empty()) return;
  std::stable_sort(links.begin(), links.end(), [](const LinkRecord* a, const LinkRecord* b) {
    return a->weakest_sigma_m > b->weakest_sigma_m;
  });
  std::vector<std::string> weak;
  weak.reserve(links.size());
  for (const LinkRecord* link : links) weak.push_back(DescribeWeakness(*link));
  run->warnings.push_back(fmt::format(
      "{} accepted link(s) do not know one direction to 5 mm by themselves, as along a street, or "
      "up and down where little ground is seen: {}; the table of links has the directions; where "
      "such links are all that leads on, the stations' sigmas in that direction may be two or "
      "three times too small; control at the far end would tell",
      weak.size(), FirstNames(weak)));
}

/// Accepted links that are further off than they say, the worst first.
void AddOverconfidentLinkWarning(RunRecord* run) {
  constexpr double kSignificant = 2.0;  // one link in 2000 where sigmas and network are right
  std::vector<const LinkRecord*> links;
  for (const LinkRecord& link : run->links) {
    if (link.status != LinkStatus::kAccepted) continue;
    if (link.network_residual_sigmas.value_or(0.0) > kSignificant) links.push_back(&link);
  }
  if (links.empty()) return;
  std::stable_sort(links.begin(), links.end(), [](const LinkRecord* a, const LinkRecord* b) {
    return *a->network_residual_sigmas > *b->network_residual_sigmas;
  });
  std::vector<std::string> names;
  names.reserve(links.size());
  for (const LinkRecord* link : links) {
    names.push_back(fmt::format("{} - {} ({:.1f} mm and {:.4f} deg: {:.1f} sigmas)", link->source,
                                link->target, 1000.0 * link->network_residual_m.value_or(0.0),
                                link->network_residual_deg.value_or(0.0),
                                *link->network_residual_sigmas));
  }
  run->warnings.push_back(fmt::format(
      "{} accepted link(s) lie further from the adjusted network than their own sigmas tell: {}; "
      "either these links know less than they say, or something is wrong there: look at closures, "
      "planes that took no part, and cross sections",
      names.size(), FirstNames(names)));
}

/// Accepted links that no figure and no picture of distances speaks of.
void AddDistanceWarnings(RunRecord* run) {
  std::set<std::set<std::string>> compared;
  const auto pairs = run->distances ? run->distances->pairs : std::vector<PairDistanceRecord>();
  for (const PairDistanceRecord& pair : pairs) {
    if (pair.figures.samples < DistanceFigures::kFewest) continue;
    compared.emplace(pair.stations.begin(), pair.stations.end());
  }
  std::vector<std::string> silent;
  for (const LinkRecord& link : run->links) {
    if (link.status != LinkStatus::kAccepted || compared.contains({link.source, link.target})) {
      continue;
    }
    silent.push_back(link.source + " - " + link.target);
  }
  if (silent.empty()) return;
  run->warnings.push_back(fmt::format(
      "{} accepted link(s) join stations whose surfaces could be compared in fewer than {} places, "
      "so that the distances say nothing of them, as where both saw the same only from afar: {}; "
      "look at both in the cross sections",
      silent.size(), DistanceFigures::kFewest, FirstNames(silent)));
}

/// Stations whose pairs showed that their scanners stood elsewhere than their scans say.
void AddScannerWarnings(const std::vector<Station>& stations, RunRecord* run) {
  for (const Station& station : stations) {
    if (!station.usable() || station.model.scanner_place != ScannerPlace::kUnknown) continue;
    run->warnings.push_back(fmt::format("station {}: {}", station.spec.id, kScannerForgotten));
  }
}

/// Attempts at pairs that ended before their end.
void AddPairWarnings(const std::vector<Station>& stations, const PairDiscovery& discovery,
                     RunRecord* run) {
  const auto id = [&](int station) { return stations[static_cast<std::size_t>(station)].spec.id; };
  for (const Pair& pair : discovery.pairs) {
    const std::string name = fmt::format("pair {} - {}", id(pair.source), id(pair.target));
    if (!pair.fault.empty()) {
      run->warnings.push_back(name + " failed: " + pair.fault);
    } else if (!pair.further_fault.empty()) {
      run->warnings.push_back(
          fmt::format("{}: a further attempt failed, what was found before it "
                      "stands: {}",
                      name, pair.further_fault));
    }
  }
}

/// Components whose planes were given up: they stand as the pairs alone have them.
void AddRefinementWarnings(RunRecord* run) {
  for (const ComponentRecord& component : run->components) {
    constexpr std::string_view kKept = "kept_pose_graph_";
    if (!component.refinement.starts_with(kKept)) continue;
    run->warnings.push_back(fmt::format(
        "component {}: the planes of all stations gave no better network ({}), that of the pairs "
        "stands",
        ComponentNumber(component.component),
        CodeWords(component.refinement.substr(kKept.size()))));
  }
}

/// Stations that saw through each other's surfaces.
void AddConflictWarnings(const std::vector<Station>& stations, const Network& network,
                         RunRecord* run) {
  const auto id = [&](int station) { return stations[static_cast<std::size_t>(station)].spec.id; };
  for (const PlacementConflict& pair : network.check.conflicts) {
    run->warnings.push_back(fmt::format(
        "stations {} and {} contradict each other: {:.0f} % of the surfaces in view were seen "
        "through; look at both in the cross sections",
        id(pair.a), id(pair.b), 100.0 * pair.conflict));
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

}  // namespace

void AddWarnings(const SurveyProject& project, const std::vector<Station>& stations,
                 const PairDiscovery& discovery, const Network& network,
                 const GeoreferencedNetwork& ground, RunRecord* run) {
  AddPoseWarnings(run);
  AddAmbiguityWarnings(stations, network, run);
  AddComponentWarnings(run);
  AddLevelHint(project, run);
  AddScannerWarnings(stations, run);
  AddLinkWarnings(run);
  AddWeakLinkWarning(run);
  AddOverconfidentLinkWarning(run);
  AddDistanceWarnings(run);
  AddPairWarnings(stations, discovery, run);
  AddRefinementWarnings(run);
  AddConflictWarnings(stations, network, run);
  AddHeldOutWarnings(stations, network, run);
  for (std::string& warning : GroundWarnings(project, ground, run->georeference)) {
    run->warnings.push_back(std::move(warning));
  }
  for (std::string& warning : SightingWarnings(project, stations)) {
    run->warnings.push_back(std::move(warning));
  }
}

}  // namespace backsight
