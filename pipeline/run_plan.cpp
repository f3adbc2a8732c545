#include "pipeline/run_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "core/error.h"
#include "io/output_names.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/fault_record.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/artifacts/network_artifact.h"
#include "pipeline/artifacts/output_units.h"
#include "pipeline/artifacts/scan_fingerprints.h"
#include "pipeline/cloud_outputs.h"
#include "pipeline/map_output.h"
#include "pipeline/output_files.h"

namespace backsight {
namespace {

using Kind = ArtifactState::Kind;

/// Lines of a key that depend on results, which a plan does not know.
bool DependsOnResults(const std::string& line) {
  return line == "motion" || line == "before" || line == "member" || line == "component" ||
         line == "path" || line == "ground" || line.starts_with("pair ");
}

std::string Join(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  const std::size_t shown = std::min(names.size(), kMost);
  return fmt::format(
      "{}{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
      names.size() > shown ? fmt::format(" and {} more", names.size() - shown) : "");
}

class Planner {
 public:
  Planner(const SurveyProject& project, const SurveyOptions& options, std::uint64_t seed,
          const ArtifactStore& store, EarlierFaults faults)
      : project_(project), base_{options, seed}, store_(store), faults_(faults) {}

  RunPlan Make(const std::string& out_directory) {
    stored_network_ = KeyLines(store_.Look(kNetworkName, {}).key_text);
    for (const StationSpec& spec : project_.stations) PlanStation(spec);
    SkipRefused();
    ForgetKnownScanners();
    PlanPairs();
    PlanNetwork();
    PlanOutputs(out_directory);
    return std::move(plan_);
  }

 private:
  /// `causes`: what it depends on and is not up to date.
  PlanItem Judge(const std::string& unit, const std::string& name, const ArtifactKey& wanted,
                 const std::vector<std::string>& causes) {
    ArtifactState state = store_.Look(name, wanted);
    PlanItem item{unit, state.kind, ""};
    if (state.kind == Kind::kDamaged) item.why = state.why.front();
    if (state.kind == Kind::kMissing && !causes.empty()) item.why = "after " + Join(causes);
    if (state.kind != Kind::kOutdated && state.kind != Kind::kUpToDate) return item;
    std::vector<std::string> changed;
    std::copy_if(state.why.begin(), state.why.end(), std::back_inserter(changed),
                 [](const std::string& line) { return !DependsOnResults(line); });
    item.unsure = changed.empty() && AddCauses(causes, &changed);
    item.state = changed.empty() ? Kind::kUpToDate : Kind::kOutdated;
    item.why = Join(changed);
    if (item.unsure) unsure_.insert(unit);
    return item;
  }

  /// Adds the causes that may bring another result. True where none but unsure ones do.
  bool AddCauses(const std::vector<std::string>& causes, std::vector<std::string>* changed) {
    std::copy_if(causes.begin(), causes.end(), std::back_inserter(*changed),
                 [&](const std::string& unit) { return !same_again_.contains(unit); });
    return !changed->empty() &&
           std::all_of(changed->begin(), changed->end(),
                       [&](const std::string& unit) { return unsure_.contains(unit); });
  }

  /// What the last run failed at is the same fault again until something is changed.
  void AddFault(const std::string& name, const ArtifactKey& key, PlanItem* item) {
    if (item->done() || faults_ == EarlierFaults::kMend) return;
    const std::optional<std::string> fault = KnownFault(store_, name, key, DependsOnResults);
    if (!fault) return;
    item->why = *fault;
    item->failed = true;
    item->unsure = false;
  }

  static std::vector<std::string> Undone(const std::vector<PlanItem>& items) {
    std::vector<std::string> undone;
    for (const PlanItem& item : items) {
      if (!item.done() && !item.failed) undone.push_back(item.unit);
    }
    return undone;
  }

  /// The result of a station whose scan is known is known by its key, whether or not it is there.
  void PlanStation(const StationSpec& spec) {
    Station station;
    station.spec = spec;
    const std::string name = StationArtifactName(spec.id);
    const std::optional<std::string> scan = scans_.Known(spec.scan);
    const std::optional<std::string> earlier = scan ? std::nullopt : ScanOf(name);
    const ArtifactKey key = StationKey(base_, spec, scan.value_or(earlier.value_or("unknown")));
    station.digest = key.Digest();
    PlanItem item = Judge("station " + spec.id, name, key, {});
    if (scan && !item.done()) same_again_.insert(item.unit);
    if (earlier && item.done()) {
      item.state = Kind::kOutdated;
      item.unsure = true;
      item.why = "only a run reads its scan, which is new or was written to";
      unsure_.insert(item.unit);
    }
    AddFault(name, scan ? key : StationKey(base_, spec, UnreadFingerprint(spec.scan)), &item);
    if (item.failed) station.fault = item.why;
    stations_.push_back(std::move(station));
    plan_.stations.push_back(std::move(item));
  }

  /// The fingerprint of the scan that a stored station was made from.
  std::optional<std::string> ScanOf(const std::string& artifact) const {
    const auto lines = KeyLines(store_.Look(artifact, {}).key_text);
    const auto scan = lines.find("scan");
    return scan == lines.end() ? std::nullopt : std::optional(scan->second);
  }

  std::vector<std::string> UndoneEnds(std::size_t source, std::size_t target) const {
    std::vector<std::string> undone;
    for (const std::size_t s : {target, source}) {
      if (!plan_.stations[s].done()) undone.push_back(plan_.stations[s].unit);
    }
    return undone;
  }

  void PlanPairs() {
    const auto usable = static_cast<int>(std::count_if(
        stations_.begin(), stations_.end(), [](const Station& s) { return s.usable(); }));
    plan_.all_pairs = IsExhaustive(usable, base_.options.pair_selection);
    for (const Pair& pair : backsight::PlanPairs(stations_, project_.pairs)) {
      const auto s = static_cast<std::size_t>(pair.source);
      const auto t = static_cast<std::size_t>(pair.target);
      planned_.insert(NameOf(s, t));
      for (const std::string_view method : {"full", "predicted", "thorough", "symmetries"}) {
        const std::string name = PairArtifactName(stations_[s], stations_[t], method);
        const bool wanted = plan_.all_pairs && method == "full";
        const bool used = wanted || IsUsed(name, NameOf(s, t));
        if (!used && !HoldsFault(store_, name)) continue;  // as of most pairs of many stations
        const std::string unit =
            fmt::format("pair {} {} {}", stations_[s].spec.id, stations_[t].spec.id, method);
        const ArtifactKey key = PairKey(base_, method, stations_[s], stations_[t], {}, "");
        PlanItem item = Judge(unit, name, key, UndoneEnds(s, t));
        AddFault(name, key, &item);
        if (used || item.failed) plan_.pairs.push_back(std::move(item));
      }
    }
  }

  std::string NameOf(std::size_t source, std::size_t target) const {
    return fmt::format("pair {} {}", stations_[source].spec.id, stations_[target].spec.id);
  }

  /// Whether the attempt is the one that the stored network was made from.
  bool IsUsed(const std::string& artifact, const std::string& pair) const {
    const auto used = stored_network_.find(pair);
    if (used == stored_network_.end()) return false;
    return ArtifactKey::OfText(store_.Look(artifact, {}).key_text).Digest() == used->second;
  }

  /// Stations that an earlier run could read and yet not use are not waited for.
  void SkipRefused() {
    for (std::size_t s = 0; s < stations_.size(); ++s) {
      const auto stored = stored_network_.find("station " + stations_[s].spec.id);
      const bool refused = stored != stored_network_.end() && stored->second == "unusable";
      if (refused && plan_.stations[s].done()) stations_[s].fault = "refused by an earlier run";
    }
  }

  /// As an earlier run did with the same stations.
  void ForgetKnownScanners() {
    const auto forgotten =
        LoadArtifact(store_, kScannersName, ScannersKey(base_, stations_, project_.pairs),
                     FromBytes<std::vector<int>>);
    if (!forgotten) return;
    for (const int s : *forgotten) {
      Station& station = stations_.at(static_cast<std::size_t>(s));
      station.model.scanner_place = ScannerPlace::kUnknown;
      station.digest = WithoutScanner(station.digest);
    }
  }

  /// True where the pairs of the stored network are no longer those of the project.
  bool HasOtherPairs() const {
    std::set<std::string> stored;
    for (const auto& [name, value] : stored_network_) {
      if (name.starts_with("pair ")) stored.insert(name);
    }
    const bool subset =
        std::includes(planned_.begin(), planned_.end(), stored.begin(), stored.end());
    return !subset || (plan_.all_pairs && stored != planned_);
  }

  void PlanNetwork() {
    std::vector<std::string> causes = Undone(plan_.stations);
    if (!stored_network_.empty() && HasOtherPairs()) causes.emplace_back("pairs");
    for (std::string& pair : Undone(plan_.pairs)) causes.push_back(std::move(pair));
    plan_.network.push_back(
        Judge("network", kNetworkName, NetworkKey(base_, stations_, {}), causes));
    network_digest_ = ArtifactKey::OfText(store_.Look(kNetworkName, {}).key_text).Digest();
    plan_.network.push_back(Judge("moving objects", kMovingName, MovingKey(base_, network_digest_),
                                  Undone(plan_.network)));
  }

  void PlanOutputs(const std::string& out_directory) {
    const ArtifactKey base = OutputsKey(base_, project_, network_digest_);
    const std::vector<int> component = Components();
    for (const CloudOutput& cloud : CloudsOfNetwork(project_, out_directory, component)) {
      PlanOutput(cloud.path, CloudKey(cloud, {}, base));
    }
    const MapOutput map = WantedMap(project_, out_directory);
    if (map.path.empty() || component.empty()) return;
    for (int c = 0; c <= *std::max_element(component.begin(), component.end()); ++c) {
      PlanOutput(ComponentPath(map.path, c), MapKey(map, c, base));
    }
  }

  /// Of the stations, by the stored network where that stays; otherwise all in one, as is hoped.
  std::vector<int> Components() const {
    const std::vector<int> together(project_.stations.size(), 0);
    if (!plan_.network.front().done()) return together;
    const ArtifactKey stored = ArtifactKey::OfText(store_.Look(kNetworkName, {}).key_text);
    const auto network = LoadArtifact(store_, kNetworkName, stored, NetworkFrom);
    return network && network->component.size() == together.size() ? network->component : together;
  }

  void PlanOutput(const std::string& path, const ArtifactKey& key) {
    PlanItem item = Judge(path, OutputArtifactName(path), key, Undone(plan_.network));
    std::error_code error;
    if (item.state == Kind::kMissing && std::filesystem::exists(path, error)) {
      item.state = Kind::kOutdated;
      item.why = "what lies there is an earlier run's";
    }
    if (item.done() && !LiesAsWritten(store_, path)) {
      item.state = Kind::kOutdated;
      item.why = "its files are gone or not as they were written";
    }
    plan_.outputs.push_back(std::move(item));
  }

  const SurveyProject& project_;
  KeyBase base_;
  const ArtifactStore& store_;
  EarlierFaults faults_;
  ScanFingerprints scans_{store_};
  std::vector<Station> stations_;  // of what a project says, with their digests
  std::multimap<std::string, std::string> stored_network_;  // lines of its key
  std::set<std::string> planned_;                           // "pair S2 S1"
  std::set<std::string> unsure_;                            // units that only a run can judge
  std::set<std::string> same_again_;  // units to be done whose results, by their keys, are known
  std::string network_digest_;
  RunPlan plan_;
};

bool AllDone(const std::vector<PlanItem>& items) { return CountDone(items) == items.size(); }

}  // namespace

std::size_t CountDone(const std::vector<PlanItem>& items) {
  return static_cast<std::size_t>(
      std::count_if(items.begin(), items.end(), [](const PlanItem& item) { return item.done(); }));
}

bool RunPlan::done() const {
  return AllDone(stations) && AllDone(pairs) && AllDone(network) && AllDone(outputs);
}

RunPlan MakeRunPlan(const SurveyProject& project, const SurveyOptions& options, std::uint64_t seed,
                    const std::string& out_directory, const ArtifactStore& store,
                    EarlierFaults faults) {
  return Planner(project, options, seed, store, faults).Make(out_directory);
}

void Restrict(const StageRange& stages, RunPlan* plan) {
  std::vector<PlanItem>* const lists[] = {&plan->stations, &plan->pairs, &plan->network,
                                          &plan->outputs};
  for (const Stage stage : kStages) {
    std::vector<PlanItem>& items = *lists[static_cast<std::size_t>(stage)];
    if (stage > stages.last) items.clear();
    if (!stages.from || stage < *stages.from) continue;
    for (PlanItem& item : items) {
      if (item.done()) item = {item.unit, Kind::kOutdated, "--from " + ToString(*stages.from)};
    }
  }
}

std::string StateText(const PlanItem& item) {
  if (item.failed) return "failed";
  if (item.unsure) return "not known";
  switch (item.state) {
    case Kind::kUpToDate:
      return "up to date";
    case Kind::kMissing:
      return "missing";
    case Kind::kOutdated:
      return "outdated";
    case Kind::kDamaged:
      return "damaged";
  }
  throw InternalError("an artifact state without a name");
}

}  // namespace backsight
