#include "stages/pair_selection.h"

#include <algorithm>
#include <numeric>

#include "stages/link_structure.h"

namespace backsight {
namespace {

using Candidates = std::span<const PairProspect>;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

bool IsOpen(const PairProspect& pair) {
  return !pair.excluded && !pair.accepted && (pair.required || !pair.too_far);
}
bool IsOpenForFull(const PairProspect& pair) { return IsOpen(pair) && !pair.tried_full; }

/// The decision of one call.
class Selector {
 public:
  Selector(int stations, Candidates candidates, const PairSelectionOptions& options)
      : stations_(stations),
        candidates_(candidates),
        options_(options),
        structure_(FindLinkStructure(stations, candidates)),
        full_tries_(At(stations), 0),
        failures_(At(stations), 0),
        matched_(At(stations), 0),
        takes_part_(At(stations), 0) {
    int spent = 0;
    int members = 0;
    for (const PairProspect& pair : candidates) {
      for (const int s : {pair.source, pair.target}) {
        if (takes_part_[At(s)] == 0) ++members;
        takes_part_[At(s)] = 1;
        full_tries_[At(s)] += pair.tried_full ? 1 : 0;
        failures_[At(s)] += pair.tried_full && !pair.accepted ? 1 : 0;
        matched_[At(s)] += pair.unmatched ? 0 : 1;
      }
      if (!pair.required) spent += (pair.tried_full ? 1 : 0) + (pair.tried_thorough ? 1 : 0);
    }
    budget_ = std::max(0, options.full_per_station * members - spent);
    by_similarity_.resize(candidates.size());
    std::iota(by_similarity_.begin(), by_similarity_.end(), 0);
    std::stable_sort(by_similarity_.begin(), by_similarity_.end(),
                     [&](std::size_t a, std::size_t b) {
                       return candidates[a].similarity > candidates[b].similarity;
                     });
    members_ = members;
  }

  PairBatch Next() {
    PairBatch batch;
    batch.pairs = Required();
    if (!batch.pairs.empty()) return batch;
    const bool exhaustive = IsExhaustive(members_, options_);
    if (!exhaustive) batch.to_match = UnmatchedAfterFailures();
    if (!batch.to_match.empty()) return batch;
    batch.pairs = exhaustive ? AllOpen()
                             : Propose(structure_.component, /*within=*/nullptr, MostTriesApart());
    if (!batch.pairs.empty()) return batch;
    batch.method = PairMethod::kPredicted;
    batch.pairs = Predicted();
    if (!batch.pairs.empty()) return batch;
    batch.method = PairMethod::kFull;
    constexpr int kControlTries = 4;
    if (!exhaustive) {
      batch.pairs = Propose(structure_.block, &structure_.component, kControlTries);
      if (!batch.pairs.empty()) return batch;
      batch.to_match = UnmatchedBetweenComponents();
      if (!batch.to_match.empty()) return batch;
      batch.pairs = BetweenComponents();
      if (!batch.pairs.empty()) return batch;
    }
    batch.method = PairMethod::kThorough;
    batch.pairs = Thorough(exhaustive);
    return batch;
  }

 private:
  std::vector<std::size_t> Required() const {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].required && IsOpenForFull(candidates_[i]) &&
          !candidates_[i].tried_predicted) {
        chosen.push_back(i);
      }
    }
    return chosen;
  }

  std::vector<std::size_t> AllOpen() const {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (IsOpenForFull(candidates_[i])) chosen.push_back(i);
    }
    return chosen;
  }

  /// The group with the most stations that take part; ties: the lower number.
  int Largest(const std::vector<int>& group, int within_component,
              const std::vector<int>* component) const {
    std::vector<int> size(At(stations_), 0);
    for (int s = 0; s < stations_; ++s) {
      if (component != nullptr && (*component)[At(s)] != within_component) continue;
      size[At(group[At(s)])] += takes_part_[At(s)];
    }
    return static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  }

  /// Every group but the largest (of each component, where `within` is given) proposes the most
  /// similar open pairs that leave it: one for each of its stations with fewer than `tries`
  /// registrations, four for a group.
  std::vector<std::size_t> Propose(const std::vector<int>& group, const std::vector<int>* within,
                                   int tries) const {
    constexpr int kPerGroup = 4;
    std::vector<int> largest(At(stations_), -1);
    for (int s = 0; s < stations_; ++s) {
      const int component = within == nullptr ? 0 : (*within)[At(s)];
      if (largest[At(component)] < 0) {
        largest[At(component)] = Largest(group, component, within);
      }
    }
    std::vector<int> proposed(At(stations_), 0);  // by station
    std::vector<int> by_group(At(stations_), 0);
    std::vector<std::size_t> chosen;
    for (const std::size_t i : by_similarity_) {
      if (static_cast<int>(chosen.size()) >= budget_) break;
      const PairProspect& pair = candidates_[i];
      if (!IsOpenForFull(pair) || group[At(pair.source)] == group[At(pair.target)]) continue;
      if (within != nullptr && (*within)[At(pair.source)] != (*within)[At(pair.target)]) continue;
      bool wanted = false;
      for (const int s : {pair.source, pair.target}) {
        const int g = group[At(s)];
        const int component = within == nullptr ? 0 : (*within)[At(s)];
        if (g == largest[At(component)] || proposed[At(s)] > 0) continue;
        if (by_group[At(g)] >= kPerGroup || full_tries_[At(s)] >= tries) continue;
        proposed[At(s)] = 1;
        ++by_group[At(g)];
        wanted = true;
      }
      if (wanted) chosen.push_back(i);
    }
    return chosen;
  }

  std::vector<std::size_t> Predicted() const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const PairProspect& pair = candidates_[i];
      if (!IsOpen(pair) || pair.tried_predicted || !pair.predicted_overlap) continue;
      const bool needed = std::min(structure_.links[At(pair.source)],
                                   structure_.links[At(pair.target)]) < options_.links_per_station;
      const double least = options_.predicted_overlap * (needed ? 0.5 : 1.0);
      if (*pair.predicted_overlap >= least) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return *candidates_[a].predicted_overlap > *candidates_[b].predicted_overlap;
    });
    std::vector<int> links = structure_.links;
    std::vector<std::size_t> chosen;
    for (const std::size_t i : order) {
      int& source = links[At(candidates_[i].source)];
      int& target = links[At(candidates_[i].target)];
      if (std::min(source, target) >= options_.max_links_per_station) continue;
      ++source, ++target;
      chosen.push_back(i);
    }
    return chosen;
  }

  /// Registrations of a station that may be spent on proposals of its component.
  int MostTriesApart() const { return options_.full_per_station - 2; }

  /// How many registrations between components may be asked for at once.
  int MostBetweenComponents() const {
    const int width = std::max(16, members_ / 4);
    return options_.until_connected ? width : std::min(width, budget_ - members_);
  }

  bool IsApart(const PairProspect& pair) const {
    return structure_.component[At(pair.source)] != structure_.component[At(pair.target)];
  }

  /// Unmatched pairs between components, the most similar first, of which `is_wanted`, as far as
  /// matches are left; ascending.
  template <class IsWanted>
  std::vector<std::size_t> Unmatched(IsWanted is_wanted) const {
    const auto matched = std::count_if(candidates_.begin(), candidates_.end(),
                                       [](const PairProspect& pair) { return !pair.unmatched; });
    const std::ptrdiff_t most = std::ptrdiff_t{options_.matched_per_station} * members_ - matched;
    std::vector<std::size_t> chosen;
    for (const std::size_t i : by_similarity_) {
      if (std::ssize(chosen) >= most) break;
      const PairProspect& pair = candidates_[i];
      if (!pair.unmatched || !IsOpenForFull(pair) || !IsApart(pair)) continue;
      if (is_wanted(pair)) chosen.push_back(i);
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
  }

  std::vector<std::size_t> UnmatchedBetweenComponents() const {
    if (MostBetweenComponents() <= 0) return {};
    return Unmatched([](const PairProspect&) { return true; });
  }

  /// What the ranking took for likely failed: it may not have seen the right ones.
  std::vector<std::size_t> UnmatchedAfterFailures() const {
    if (budget_ <= 0) return {};
    const int largest = Largest(structure_.component, 0, nullptr);
    std::vector<int> wanted(At(stations_), 0);
    for (std::size_t s = 0; s < wanted.size(); ++s) {
      if (structure_.component[s] == largest || full_tries_[s] >= MostTriesApart()) continue;
      if (failures_[s] == 0) continue;
      wanted[s] = options_.matched_per_failure * (1 + failures_[s]) - matched_[s];
    }
    return Unmatched([&](const PairProspect& pair) {
      int& source = wanted[At(pair.source)];
      int& target = wanted[At(pair.target)];
      const bool is_wanted = std::max(source, target) > 0;
      if (is_wanted) --source, --target;
      return is_wanted;
    });
  }

  std::vector<std::size_t> BetweenComponents() const {
    const int most = MostBetweenComponents();
    std::vector<std::size_t> chosen;
    for (const std::size_t i : by_similarity_) {
      if (static_cast<int>(chosen.size()) >= most) break;
      const PairProspect& pair = candidates_[i];
      if (IsOpenForFull(pair) && IsApart(pair)) chosen.push_back(i);
    }
    return chosen;
  }

  std::vector<std::size_t> Thorough(bool exhaustive) const {
    std::vector<std::size_t> chosen;
    for (const std::size_t i : by_similarity_) {
      if (!exhaustive && static_cast<int>(chosen.size()) >= budget_) break;
      const PairProspect& pair = candidates_[i];
      if (!IsOpen(pair) || !pair.tried_full || pair.tried_thorough || !IsApart(pair)) continue;
      chosen.push_back(i);
    }
    return chosen;
  }

  int stations_;
  Candidates candidates_;
  const PairSelectionOptions& options_;
  LinkStructure structure_;
  std::vector<int> full_tries_;  // per station
  std::vector<int> failures_;    // of those, that did not become links
  std::vector<int> matched_;     // pairs ranked by a match, per station
  std::vector<int> takes_part_;
  int members_ = 0;
  int budget_ = 0;
  std::vector<std::size_t> by_similarity_;
};

}  // namespace

void VisitOptions(OptionVisitor& visitor, PairSelectionOptions& options) {
  visitor.Choice("strategy", options.strategy, {"auto", "exhaustive", "grow"},
                 "every pair, or from the most similar pairs to a connected network; auto decides "
                 "by exhaustive_stations");
  visitor.Integer("exhaustive_stations", options.exhaustive_stations, "1", 2, 1000,
                  "auto registers every pair of up to so many stations");
  visitor.Integer("full_per_station", options.full_per_station, "1", 3, 1000,
                  "full registrations that growing may spend, times the number of stations");
  visitor.Integer("links_per_station", options.links_per_station, "1", 1, 100,
                  "accepted links wanted of every station, where it overlaps as many others");
  visitor.Integer("max_links_per_station", options.max_links_per_station, "1", 1, 1000,
                  "accepted links after which further predicted pairs are redundant");
  visitor.Real("predicted_overlap", options.predicted_overlap, "1", 0.0, 1.0,
               "least overlap by the current poses for which a pair is registered");
  visitor.Integer(
      "matched_per_failure", options.matched_per_failure, "1", 0, 100000,
      "pairs of a station that stays apart that are ranked by a cheap match, times one more than "
      "its registrations that did not become links");
  visitor.Integer("matched_per_station", options.matched_per_station, "1", 0, 100000,
                  "pairs that are ranked by a cheap match in all while stations stay apart, times "
                  "the number of stations");
  visitor.Flag("until_connected", options.until_connected,
               "go on beyond full_per_station, to the last pair, while stations stay apart");
}

bool IsExhaustive(int stations, const PairSelectionOptions& options) {
  return options.strategy == PairSelectionOptions::kExhaustive ||
         (options.strategy == PairSelectionOptions::kAuto &&
          stations <= options.exhaustive_stations);
}

PairBatch NextPairs(int stations, Candidates candidates, const PairSelectionOptions& options) {
  return Selector(stations, candidates, options).Next();
}

bool IsCertain(const PairProspect& pair, int stations, const PairSelectionOptions& options) {
  return IsOpenForFull(pair) && (pair.required || IsExhaustive(stations, options));
}

std::string SkipReason(const PairProspect& candidate, const PairSelectionOptions& options) {
  if (candidate.tried_full || candidate.tried_predicted) return "";
  if (candidate.excluded) return "excluded";
  if (candidate.too_far) return "prior_too_far";
  if (!candidate.predicted_overlap) return "not_similar";
  return *candidate.predicted_overlap >= options.predicted_overlap ? "redundant" : "no_overlap";
}

}  // namespace backsight
