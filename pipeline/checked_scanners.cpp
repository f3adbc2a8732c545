#include "pipeline/checked_scanners.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/archive.h"
#include "core/error.h"
#include "pipeline/artifacts/load_artifact.h"
#include "stages/misplaced_scanners.h"

namespace backsight {
namespace {

/// What a scanner says of the cloud that `seen` compares with what it measured.
std::optional<double> SeenThrough(const CloudAgreement& seen) {
  if (seen.blocks_in_view < kFewestBlocksInView) return std::nullopt;
  return seen.conflict.value;
}

/// Of the pairs whose best motion many key points support and nothing but doubts forbids.
std::vector<MutualView> CollectViews(const std::vector<Pair>& pairs,
                                     const VerificationOptions& options) {
  using Reason = VerificationResult::Reason;
  std::vector<MutualView> views;
  for (const Pair& pair : pairs) {
    const PairCandidate* best = pair.best();
    if (best == nullptr || !pair.fault.empty()) continue;
    const VerificationResult& verification = best->verification;
    const bool supported =
        IsSignificant(verification.consensus, verification.consensus_null, options);
    const bool possible = pair.reason() == Reason::kNone || pair.reason() == Reason::kFreeSpace;
    if (!supported || !possible) continue;
    views.push_back({pair.source, pair.target, best->fine.target_from_source,
                     SeenThrough(verification.target_in_source),
                     SeenThrough(verification.source_in_target)});
  }
  return views;
}

std::optional<int> FindMisplaced(const PairUnits& units, const PairDiscovery& discovery) {
  if (discovery.components <= 1) return std::nullopt;
  const std::vector<Station>& stations = units.stations();
  const VerificationOptions& options = units.options().verification;
  std::vector<char> assumed(stations.size());
  std::transform(stations.begin(), stations.end(), assumed.begin(), [](const Station& station) {
    return station.model.scanner_place == ScannerPlace::kAssumed ? 1 : 0;
  });
  return FindMisplacedScanner(
      CollectViews(discovery.pairs, options),
      {discovery.network.survey_from_station, discovery.network.component, assumed},
      options.sure_conflict, units.options().ingest.resolution_m);
}

/// False where that failed; the station is as it was then.
bool TryToForget(const PairUnits& units, int misplaced, std::vector<Station>* stations) {
  Station& station = stations->at(static_cast<std::size_t>(misplaced));
  try {
    ForgetScanner(units.options(), units.context(), &station);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    units.context().Warning(fmt::format(
        "station {}: its scanner seems not to have stood at the scan's origin, but its surface "
        "could not be described without it: {}",
        station.spec.id, error.what()));
    return false;
  }
  units.context().Info(fmt::format("station {}: {}", station.spec.id, kScannerForgotten));
  return true;
}

bool RanToTheirEnds(const std::vector<Pair>& pairs) {
  return std::all_of(pairs.begin(), pairs.end(), [](const Pair& pair) {
    return pair.fault.empty() && pair.further_fault.empty();
  });
}

}  // namespace

PairDiscovery DiscoverWithCheckedScanners(const PairUnits& units, const PairSpec& spec,
                                          RegisteredPairs early, std::vector<Station>* stations) {
  BACKSIGHT_CHECK(stations == &units.stations(), "the units' own stations are described anew");
  const ArtifactStore& store = units.store();
  const ArtifactKey key = ScannersKey({units.options(), units.context().seed()}, *stations, spec);
  std::vector<int> forgotten = LoadArtifact(store, kScannersName, key, FromBytes<std::vector<int>>)
                                   .value_or(std::vector<int>());
  for (const int s : forgotten) {
    if (!TryToForget(units, s, stations)) continue;
    std::erase_if(early, [s](const auto& registered) {
      return registered.first.first == s || registered.first.second == s;
    });
  }
  bool whole = true;  // what follows a fault is not for other runs
  while (true) {
    PairDiscovery discovery = DiscoverPairs(units, spec, std::exchange(early, {}));
    whole = whole && RanToTheirEnds(discovery.pairs);
    const std::optional<int> misplaced = FindMisplaced(units, discovery);
    if (!misplaced || !TryToForget(units, *misplaced, stations)) return discovery;
    forgotten.push_back(*misplaced);
    if (store.keeps() && whole) store.Store(kScannersName, key, ToBytes(forgotten));
  }
}

}  // namespace backsight
