#include "pipeline/pair_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>
#include <utility>

#include "pipeline/artifacts/pair_artifact.h"
#include "pipeline/candidate_links.h"
#include "pipeline/grouped_work.h"
#include "pipeline/pair_prospects.h"
#include "pipeline/pair_rankings.h"
#include "stages/link_structure.h"
#include "stages/overlap_prediction.h"
#include "stages/pair_selection.h"

namespace backsight {
namespace {

std::size_t At(int index) { return static_cast<std::size_t>(index); }

/// The state of one discovery.
class Discovery {
 public:
  Discovery(const PairUnits& units, const PairSpec& spec, RegisteredPairs early)
      : units_(units),
        stations_(units.stations()),
        options_(units.options()),
        context_(units.context()),
        early_(std::move(early)),
        candidates_(ListProspects(stations_, spec)),
        pairs_(candidates_.size()),
        predicted_with_(candidates_.size()) {
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      pairs_[i].source = candidates_[i].source;
      pairs_[i].target = candidates_[i].target;
    }
  }

  PairDiscovery Run() {
    Prepare();
    while (true) {
      const PairBatch batch = Next();
      if (batch.pairs.empty()) break;
      Register(batch);
    }
    return Summarize();
  }

  DiscoveryFrontier Replay() {
    Prepare();
    DiscoveryFrontier frontier;
    while (frontier.missing.empty()) {
      const PairBatch batch = Next();
      if (batch.pairs.empty()) break;
      for (const std::size_t i : batch.pairs) ReplayOne(batch.method, i, &frontier);
    }
    return frontier;
  }

 private:
  void Prepare() {
    const auto usable = static_cast<int>(std::count_if(
        stations_.begin(), stations_.end(), [](const Station& s) { return s.usable(); }));
    const bool growing = !IsExhaustive(usable, options_.pair_selection);
    if (growing) {
      RankOnce(units_, &candidates_);
    }
    occupancy_.resize(stations_.size());
    context_.ParallelFor(stations_.size(), [&](std::size_t s) {
      if (stations_[s].usable()) occupancy_[s].emplace_back(stations_[s].model);
    });
  }

  PairBatch Next() {
    context_.CheckStop();
    ChooseNetwork();
    PredictOverlaps();
    while (true) {
      PairBatch batch =
          NextPairs(static_cast<int>(stations_.size()), candidates_, options_.pair_selection);
      if (batch.to_match.empty()) return batch;
      context_.Debug(fmt::format("pairs: {} between components ranked", batch.to_match.size()));
      MatchOnce(units_, batch.to_match, ++rankings_, &candidates_);
    }
  }

  /// The network of all pairs so far: its links are the accepted ones, its poses predict.
  void ChooseNetwork() {
    std::vector<NetworkLink> links;
    for (const CandidateLink& made : MakeCandidateLinks(pairs_, options_.verification)) {
      links.push_back(made.link);
    }
    network_ = ChooseLinks(static_cast<int>(stations_.size()), links, options_.network,
                           [&] { context_.CheckStop(); });
    for (PairProspect& candidate : candidates_) candidate.accepted = false;
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (network_.fate[l] == LinkFate::kUsed) candidates_[At(links[l].pair)].accepted = true;
    }
  }

  RigidTransform Relative(std::size_t i) const {
    return network_.survey_from_station[At(candidates_[i].target)].Inverse() *
           network_.survey_from_station[At(candidates_[i].source)];
  }

  /// Only pairs whose stations have moved against each other are looked at again.
  void PredictOverlaps() {
    context_.ParallelFor(
        candidates_.size(),
        [&](std::size_t i) {
          PairProspect& candidate = candidates_[i];
          const auto [s, t] = std::pair(At(candidate.source), At(candidate.target));
          if (network_.component[s] != network_.component[t]) {
            candidate.predicted_overlap.reset();
            predicted_with_[i].reset();
            return;
          }
          const RigidTransform motion = Relative(i);
          const double l = stations_[t].model.resolution_m();
          const auto& before = predicted_with_[i];
          if (before && (motion.translation - before->translation).norm() < l &&
              RotationAngle(motion.rotation, before->rotation) < 0.005) {
            return;
          }
          predicted_with_[i] = motion;
          const double reach_m = stations_[s].record.extent_m + stations_[t].record.extent_m;
          candidate.predicted_overlap =
              motion.translation.norm() > reach_m
                  ? 0.0
                  : PredictOverlap(occupancy_[s].front(), occupancy_[t].front(), motion);
        },
        /*grain=*/64);
  }

  void Register(const PairBatch& batch) {
    const std::size_t total = tried_ + batch.pairs.size();
    const std::vector<std::size_t> left = TakeEarly(batch);
    std::atomic<std::size_t> done = total - left.size();
    context_.Progress("pairs", done, total);
    std::vector<GroupedWork> works;  // the planes of a target are made once for all its pairs
    works.reserve(left.size());
    for (const std::size_t i : left) {
      works.push_back({candidates_[i].target, LeavesOf(candidates_[i])});
    }
    LargestGroupsFirst(works, context_, [&](std::size_t k) {
      RegisterOne(batch.method, left[k]);
      context_.Progress("pairs", ++done, total);
    });
    tried_ = total;
    RetryAlone(batch);
    const int count = static_cast<int>(batch.pairs.size());
    (batch.method == PairMethod::kPredicted ? predicted_ : full_) += count;
    if (batch.method == PairMethod::kThorough) thorough_ += count;
    context_.Debug(fmt::format("pairs: {} {}", count, Name(batch.method)));
  }

  /// What was registered beside the stations; returns the others.
  std::vector<std::size_t> TakeEarly(const PairBatch& batch) {
    if (batch.method != PairMethod::kFull) return batch.pairs;
    std::vector<std::size_t> left;
    for (const std::size_t i : batch.pairs) {
      const auto found = early_.find({candidates_[i].source, candidates_[i].target});
      if (found == early_.end()) {
        left.push_back(i);
        continue;
      }
      BeginAttempt(batch.method, i);
      pairs_[i] = std::move(found->second);
      early_.erase(found);
    }
    return left;
  }

  /// Of both stations, which says roughly how long the pair takes.
  double LeavesOf(const PairProspect& candidate) const {
    return static_cast<double>(stations_[At(candidate.source)].model.leaves.size() +
                               stations_[At(candidate.target)].model.leaves.size());
  }

  /// Pairs that found no memory beside others, one after the other.
  void RetryAlone(const PairBatch& batch) {
    for (const std::size_t i : batch.pairs) {
      if (!pairs_[i].short_of_memory) continue;
      pairs_[i].short_of_memory = false;
      pairs_[i].further_fault.clear();
      RegisterOne(batch.method, i);
      if (!pairs_[i].short_of_memory) continue;
      (pairs_[i].best() == nullptr ? pairs_[i].fault : pairs_[i].further_fault) = kShortOfMemory;
      context_.Warning(fmt::format("pair {} {}: {}", stations_[At(pairs_[i].source)].spec.id,
                                   stations_[At(pairs_[i].target)].spec.id, kShortOfMemory));
    }
  }

  static const char* Name(PairMethod method) {
    switch (method) {
      case PairMethod::kFull:
        return "registered fully";
      case PairMethod::kPredicted:
        return "registered from predicted poses";
      case PairMethod::kThorough:
        return "tried again thoroughly";
    }
    return "";
  }

  void RegisterOne(PairMethod method, std::size_t i) {
    const std::optional<RigidTransform> predicted = BeginAttempt(method, i);
    units_.Register(method, predicted, &pairs_[i]);
  }

  void ReplayOne(PairMethod method, std::size_t i, DiscoveryFrontier* frontier) {
    const std::optional<RigidTransform> predicted = BeginAttempt(method, i);
    Pair& pair = pairs_[i];
    if (units_.Replay(method, predicted, &pair)) {
      ++frontier->done;
    } else {
      frontier->missing.push_back(
          {pair.source, pair.target, method, predicted, PairBytes(pair), pair.digest});
    }
  }

  /// What the pair starts from; of PairMethod::kPredicted its motion.
  std::optional<RigidTransform> BeginAttempt(PairMethod method, std::size_t i) {
    PairProspect& candidate = candidates_[i];
    std::optional<RigidTransform> predicted;
    if (method == PairMethod::kThorough) {
      candidate.tried_thorough = true;
    } else if (method == PairMethod::kFull) {
      candidate.tried_full = true;
      pairs_[i] = Pair();
      pairs_[i].source = candidate.source;
      pairs_[i].target = candidate.target;
    } else {
      candidate.tried_predicted = true;
      predicted = Relative(i);
    }
    return predicted;
  }

  PairDiscovery Summarize() {
    PairDiscovery found;
    found.full = full_;
    found.predicted = predicted_;
    int accepted = 0;
    std::map<std::string, int> reasons;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const PairProspect& candidate = candidates_[i];
      const std::string reason = SkipReason(candidate, options_.pair_selection);
      accepted += candidate.accepted ? 1 : 0;
      if (reason.empty()) {
        found.pairs.push_back(std::move(pairs_[i]));
      } else {
        ++reasons[reason];
        found.skipped.push_back({candidate.source, candidate.target, reason});
      }
    }
    const LinkStructure structure =
        FindLinkStructure(static_cast<int>(stations_.size()), candidates_);
    std::set<int> components;
    for (std::size_t s = 0; s < stations_.size(); ++s) {
      if (stations_[s].usable()) components.insert(structure.component[s]);
    }
    found.components = static_cast<int>(components.size());
    found.network = std::move(network_);
    std::string skipped;
    for (const auto& [reason, count] : reasons) {
      skipped += fmt::format("{}{} {}", skipped.empty() ? "" : ", ", count, reason);
    }
    context_.Info(fmt::format(
        "pairs: {} of {} tried, {} accepted before the network decides, {} skipped{}; {} attempts: "
        "{} in full, {} again thoroughly, {} from predicted poses; {} component(s), stations alone "
        "among them",
        found.pairs.size(), candidates_.size(), accepted, found.skipped.size(),
        skipped.empty() ? "" : " (" + skipped + ")", full_ + predicted_, full_ - thorough_,
        thorough_, predicted_, found.components));
    return found;
  }

  const PairUnits& units_;
  const std::vector<Station>& stations_;
  const SurveyOptions& options_;
  const ExecutionContext& context_;
  RegisteredPairs early_;  // not taken yet
  std::vector<PairProspect> candidates_;
  std::vector<Pair> pairs_;  // by candidate; the last attempt worth keeping
  std::vector<std::optional<RigidTransform>> predicted_with_;
  std::vector<std::vector<CoarseOccupancy>> occupancy_;  // by station, one where usable
  LinkSelection network_;
  std::size_t tried_ = 0;
  int full_ = 0;      // thorough ones included
  int thorough_ = 0;  // second tries of pairs
  int predicted_ = 0;
  int rankings_ = 0;  // further ones, of pairs between components
};

}  // namespace

PairDiscovery DiscoverPairs(const PairUnits& units, const PairSpec& spec, RegisteredPairs early) {
  return Discovery(units, spec, std::move(early)).Run();
}

DiscoveryFrontier FindFrontier(const PairUnits& units, const PairSpec& spec) {
  return Discovery(units, spec, {}).Replay();
}

}  // namespace backsight
