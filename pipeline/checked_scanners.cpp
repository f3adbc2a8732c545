#include "pipeline/checked_scanners.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/archive.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/candidate_links.h"
#include "stages/misplaced_scanners.h"

namespace backsight {
namespace {

/// What a scanner says of the cloud that `seen` compares with what it measured.
std::optional<double> SeenThrough(const CloudAgreement& seen) {
  constexpr int kFewestBlocks = 50;  // in view
  if (seen.blocks_in_view < kFewestBlocks) return std::nullopt;
  return seen.conflict.value;
}

/// Of the pairs whose best motion many key points support, whatever free space says of it.
std::vector<MutualView> CollectViews(const std::vector<Pair>& pairs,
                                     const VerificationOptions& options) {
  using Reason = VerificationResult::Reason;
  std::vector<MutualView> views;
  for (const Pair& pair : pairs) {
    const PairCandidate* best = pair.best();
    if (best == nullptr) continue;
    const VerificationResult& verification = best->verification;
    const bool supported =
        IsSignificant(verification.consensus, verification.consensus_null, options);
    const bool only_seen_through =
        pair.reason() == Reason::kNone || pair.reason() == Reason::kFreeSpace;
    if (!supported || !only_seen_through) continue;
    views.push_back({pair.source, pair.target, best->fine.target_from_source,
                     SeenThrough(verification.target_in_source),
                     SeenThrough(verification.source_in_target)});
  }
  return views;
}

/// Ascending. Scanners that the user vouches for are believed.
std::vector<int> FindMisplaced(const PairUnits& units, const std::vector<Pair>& pairs) {
  const std::vector<Station>& stations = units.stations();
  std::vector<NetworkLink> links;
  for (const CandidateLink& made : MakeCandidateLinks(pairs, units.options().verification)) {
    links.push_back(made.link);
  }
  const LinkSelection network =
      ChooseLinks(static_cast<int>(stations.size()), links, units.options().network,
                  [&] { units.context().CheckStop(); });
  std::vector<int> misplaced = FindMisplacedScanners(
      CollectViews(pairs, units.options().verification),
      {network.survey_from_station, network.component}, units.options().verification.sure_conflict,
      units.options().ingest.resolution_m);
  std::erase_if(misplaced, [&](int s) {
    return stations[static_cast<std::size_t>(s)].model.scanner_place != ScannerPlace::kAssumed;
  });
  return misplaced;
}

void ForgetScanners(const PairUnits& units, const std::vector<int>& misplaced,
                    std::vector<Station>* stations) {
  for (const int s : misplaced) {
    Station& station = (*stations)[static_cast<std::size_t>(s)];
    ForgetScanner(units.options(), units.context(), &station);
    units.context().Warning(fmt::format("station {}: {}", station.spec.id,
                                        station.usable() ? station.record.notes.back()
                                                         : station.fault));
  }
}

bool RanToTheirEnds(const std::vector<Pair>& pairs) {
  return std::all_of(pairs.begin(), pairs.end(), [](const Pair& pair) {
    return pair.fault.empty() && pair.further_fault.empty();
  });
}

}  // namespace

PairDiscovery DiscoverWithCheckedScanners(const PairUnits& units, const PairSpec& spec,
                                          std::vector<Station>* stations) {
  const ArtifactStore& store = units.store();
  const ArtifactKey key =
      ScannersKey({units.options(), units.context().seed()}, *stations, spec);
  if (const auto known =
          LoadArtifact(store, kScannersName, key, FromBytes<std::vector<int>>)) {
    ForgetScanners(units, *known, stations);
    return DiscoverPairs(units, spec);
  }
  std::vector<int> misplaced;
  while (true) {
    PairDiscovery discovery = DiscoverPairs(units, spec);
    const std::vector<int> more = FindMisplaced(units, discovery.pairs);
    if (more.empty()) {
      if (store.keeps() && RanToTheirEnds(discovery.pairs)) {
        store.Store(kScannersName, key, ToBytes(misplaced));
      }
      return discovery;
    }
    ForgetScanners(units, more, stations);
    misplaced.insert(misplaced.end(), more.begin(), more.end());
  }
}

}  // namespace backsight
