#include "graph/link_selection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "graph/graph_connectivity.h"
#include "graph/spanning_tree.h"
#include "graph/tree_loops.h"

namespace backsight {
namespace {

std::size_t Slot(int k) { return static_cast<std::size_t>(k); }

class Selector {
 public:
  Selector(int stations, std::span<const PoseGraphLink> links, std::span<const LinkSupport> support,
           const SelectionOptions& options)
      : stations_(stations),
        links_(links),
        support_(support),
        options_(options),
        eligible_(links.size(), 1),
        used_(links.size(), 0),
        barred_(links.size(), 0),
        dropped_as_(links.size(), LinkFate::kContradictsNetwork) {
    FindLeads();
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (!links[l].doubtful) continue;
      if (support[l].confirmed >= 1 || support[l].valid >= 2 || support[l].part_loops >= 1)
        continue;
      Drop(l, LinkFate::kUnconfirmed);
    }
  }

  LinkSelection Select() {
    StartFromForest();
    for (;;) {
      ImprovePlacements();
      if (DropUnconfirmed()) continue;
      if (!CutAmbiguous()) break;
    }
    return Report();
  }

 private:
  /// By how much each link's score leads the best other one of its pair; 0 if it has no rival.
  void FindLeads() {
    std::map<int, std::vector<int>> by_pair;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (links_[l].pair >= 0) by_pair[links_[l].pair].push_back(static_cast<int>(l));
    }
    lead_.assign(links_.size(), 0.0);
    rivals_.resize(links_.size());
    for (const auto& [pair, own] : by_pair) {
      if (own.size() < 2) continue;
      for (const int l : own) {
        double best_other = -1e300;
        for (const int k : own) {
          if (k == l) continue;
          best_other = std::max(best_other, links_[Slot(k)].score);
          rivals_[Slot(l)].push_back(k);
        }
        lead_[Slot(l)] = links_[Slot(l)].score - best_other;
      }
    }
  }

  void Drop(std::size_t l, LinkFate fate) {
    eligible_[l] = 0;
    used_[l] = 0;
    dropped_as_[l] = fate;
  }

  double Limit(std::size_t l) const {
    const LinkSupport& own = support_[l];
    const bool denied = own.valid == 0 && own.invalid > 0 && own.part_loops == 0;
    return denied ? options_.unsupported_limit : options_.outlier_limit;
  }

  bool RivalIsUsed(int l) const {
    return std::any_of(rivals_[Slot(l)].begin(), rivals_[Slot(l)].end(),
                       [&](int k) { return used_[Slot(k)] != 0; });
  }

  /// Eligible links, the most trusted first.
  std::vector<int> ByTrust() const {
    std::vector<int> order;
    for (int l = 0; l < static_cast<int>(links_.size()); ++l) {
      if (eligible_[Slot(l)] != 0) order.push_back(l);
    }
    const auto key = [&](int l) {
      return std::make_tuple(support_[Slot(l)].valid, lead_[Slot(l)], links_[Slot(l)].confidence);
    };
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) > key(b); });
    return order;
  }

  void StartFromForest() {
    const std::vector<int> order = ByTrust();
    const SpanningForest forest = BuildForestInOrder(stations_, links_, order);
    poses_ = forest.survey_from_station;
    for (const int l : forest.tree_links) used_[Slot(l)] = 1;
    const std::vector<double> closing = TreeLoopErrors(stations_, links_, forest);
    first_contradicted_.assign(links_.size(), 0);
    for (const int l : order) {
      if (used_[Slot(l)] != 0 || RivalIsUsed(l)) continue;
      if (closing[Slot(l)] <= Limit(Slot(l)))
        used_[Slot(l)] = 1;
      else
        first_contradicted_[Slot(l)] = 1;
    }
    Adjust();
    Settle();
  }

  void Adjust() {
    if (options_.between) options_.between();
    std::vector<double> weights(used_.begin(), used_.end());
    const std::vector<int> component = FindComponents(stations_, links_, used_);
    ResetDatum(component, &poses_);
    AdjustPoses(links_, weights, FirstOfEachComponent(component), options_.max_iterations, &poses_);
  }

  /// Joins parts that fell apart by the most trusted links between them, each part as it is.
  void JoinParts() {
    std::vector<int> component = FindComponents(stations_, links_, used_);
    for (const int l : ByTrust()) {
      const PoseGraphLink& link = links_[Slot(l)];
      const int from = component[Slot(link.source)];
      const int to = component[Slot(link.target)];
      if (from == to || RivalIsUsed(l)) continue;
      const RigidTransform move =
          poses_[Slot(link.target)] * link.target_from_source * poses_[Slot(link.source)].Inverse();
      for (std::size_t s = 0; s < component.size(); ++s) {
        if (component[s] != from) continue;
        poses_[s] = move * poses_[s];
        component[s] = to;
      }
      used_[Slot(l)] = 1;
    }
  }

  /// Of each pair the eligible link that fits best, if it fits.
  std::vector<char> FittingLinks() const {
    std::vector<double> error(links_.size(), 1e300);
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (eligible_[l] != 0) error[l] = SquaredError(links_[l], poses_);
    }
    std::vector<char> fitting(links_.size(), 0);
    for (std::size_t l = 0; l < links_.size(); ++l) {
      fitting[l] =
          error[l] <= Limit(l) && std::none_of(rivals_[l].begin(), rivals_[l].end(),
                                               [&](int k) {
                                                 return error[Slot(k)] < error[l] ||
                                                        (error[Slot(k)] == error[l] && Slot(k) < l);
                                               })
              ? 1
              : 0;
    }
    return fitting;
  }

  void Settle() {
    constexpr int kMaxRounds = 20;
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::vector<char> before = used_;
      // Parts without a used link between them stand anywhere: what fits there does so by chance.
      used_ = FittingLinks();
      RemoveBetween(FindComponents(stations_, links_, before));
      JoinParts();
      if (used_ == before) return;
      Adjust();
    }
  }

  void RemoveBetween(const std::vector<int>& component) {
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (component[Slot(links_[l].source)] != component[Slot(links_[l].target)]) used_[l] = 0;
    }
  }

  std::vector<RivalPlacement> Rivals() const {
    return FindRivalPlacements(
        links_, eligible_, used_, poses_,
        {.limit = options_.outlier_limit, .score_noise = options_.score_noise});
  }

  void ImprovePlacements() {
    for (int move = 0; move < 4 * stations_; ++move) {
      const RivalPlacement* best = nullptr;
      const std::vector<RivalPlacement> rivals = Rivals();
      for (const RivalPlacement& rival : rivals) {
        if (rival.margin >= -1e-9 || barred_[Slot(rival.links.front())] != 0) continue;
        if (best == nullptr || rival.margin < best->margin) best = &rival;
      }
      if (best == nullptr) return;
      const auto used_before = used_;
      const auto poses_before = poses_;
      const double before = Merit();
      for (const int s : best->stations) {
        RigidTransform& pose = poses_[Slot(s)];
        pose = best->displacement * pose;
      }
      TakeAcross(*best);
      Adjust();
      Settle();
      ++moves_;
      if (Merit() > before) continue;
      used_ = used_before;
      poses_ = poses_before;
      --moves_;
      barred_[Slot(best->links.front())] = 1;
    }
  }

  /// Exchanges the links across the cut of `placement` for those that speak for it.
  void TakeAcross(const RivalPlacement& placement) {
    std::vector<char> inside(Slot(stations_), 0);
    for (const int s : placement.stations) inside[Slot(s)] = 1;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (inside[Slot(links_[l].source)] != inside[Slot(links_[l].target)]) used_[l] = 0;
    }
    for (const int l : placement.links) {
      if (!RivalIsUsed(l)) used_[Slot(l)] = 1;
    }
  }

  /// What the used links are worth, in the unit of RivalPlacement::margin.
  double Merit() const {
    double merit = 0.0;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (used_[l] == 0) continue;
      merit += links_[l].credibility * (links_[l].doubtful ? 0.5 * kFullVote : kFullVote);
      merit += std::clamp(lead_[l] / (std::numbers::sqrt2 * options_.score_noise), -kFullVote, 0.0);
    }
    return merit;
  }

  /// The links with the parts as their ends that accepted used links hold together.
  std::vector<PoseGraphLink> BetweenParts() const {
    std::vector<char> accepted = used_;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (links_[l].doubtful) accepted[l] = 0;
    }
    const std::vector<int> part = FindComponents(stations_, links_, accepted);
    std::vector<PoseGraphLink> between(links_.begin(), links_.end());
    for (PoseGraphLink& link : between) {
      link.source = part[Slot(link.source)];
      link.target = part[Slot(link.target)];
    }
    return between;
  }

  /// A doubtful link is confirmed within a part that accepted links hold together, or where two
  /// ways over other doubtful links lead from part to part. Those must each say something by
  /// themselves: the two ends of a symmetric building ask for the same wrong motion in many pairs.
  bool IsConfirmed(std::size_t l, std::span<const PoseGraphLink> between) const {
    const PoseGraphLink& link = between[l];
    if (link.source == link.target) return true;
    std::vector<char> others = used_;
    others[l] = 0;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if (!links_[k].doubtful || links_[k].credibility < kLeastCredibility) others[k] = 0;
    }
    return CountDisjointPaths(stations_, between, others, link.source, link.target, 2) >= 2;
  }

  bool DropUnconfirmed() {
    const std::vector<PoseGraphLink> between = BetweenParts();
    std::vector<std::size_t> drop;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (used_[l] != 0 && links_[l].doubtful && !IsConfirmed(l, between)) drop.push_back(l);
    }
    for (const std::size_t l : drop) Drop(l, LinkFate::kUnconfirmed);
    if (drop.empty()) return false;
    Adjust();
    Settle();
    return true;
  }

  bool CutAmbiguous() {
    const std::vector<RivalPlacement> rivals = Rivals();
    const RivalPlacement* worst = nullptr;
    for (const RivalPlacement& rival : rivals) {
      if (!rival.Undecided()) continue;
      if (worst == nullptr || rival.margin - rival.noise < worst->margin - worst->noise) {
        worst = &rival;
      }
    }
    if (worst == nullptr) return false;
    Note(*worst);
    // Other links across the cut could join the parts again, by chance or by the same error.
    std::vector<char> inside(Slot(stations_), 0);
    for (const int s : worst->stations) inside[Slot(s)] = 1;
    const std::vector<int> component = FindComponents(stations_, links_, used_);
    const int cut = component[Slot(worst->stations.front())];
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const auto source = Slot(links_[l].source);
      const auto target = Slot(links_[l].target);
      if (eligible_[l] == 0 || inside[source] == inside[target]) continue;
      if (component[source] == cut && component[target] == cut) {
        Drop(l, LinkFate::kContradictsNetwork);
      }
    }
    for (const std::vector<int>* likely : {&worst->suspects, &worst->links}) {
      for (const int l : *likely) Drop(Slot(l), LinkFate::kAmbiguous);
    }
    Adjust();
    Settle();
    return true;
  }

  void Note(const RivalPlacement& placement) {
    Ambiguity note;
    const std::vector<int> component = FindComponents(stations_, links_, used_);
    std::vector<int> rest;
    for (int s = 0; s < stations_; ++s) {
      if (component[Slot(s)] != component[Slot(placement.stations.front())]) continue;
      if (!std::binary_search(placement.stations.begin(), placement.stations.end(), s)) {
        rest.push_back(s);
      }
    }
    const bool moved_is_smaller = placement.stations.size() != rest.size()
                                      ? placement.stations.size() < rest.size()
                                      : placement.stations.front() > rest.front();
    note.stations = moved_is_smaller ? placement.stations : rest;
    note.for_kept = placement.kept;
    note.for_rival = static_cast<int>(placement.links.size());
    note.margin = placement.margin;
    note.noise = placement.noise;
    const RigidTransform& pose = poses_[Slot(placement.stations.front())];
    const RigidTransform moved = placement.displacement * pose;
    note.shift_m = (moved.translation - pose.translation).norm();
    note.turn_deg = RotationAngle(moved.rotation, pose.rotation) * 180.0 / std::numbers::pi;
    ambiguities_.push_back(note);
  }

  LinkSelection Report() const {
    LinkSelection result;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      LinkFate fate = dropped_as_[l];
      if (used_[l] != 0) {
        fate = LinkFate::kUsed;
      } else if (fate != LinkFate::kAmbiguous && RivalIsUsed(static_cast<int>(l))) {
        fate = LinkFate::kRivalWon;
      }
      result.fate.push_back(fate);
      result.readmitted += used_[l] != 0 && first_contradicted_[l] != 0 ? 1 : 0;
    }
    result.survey_from_station = poses_;
    result.component = FindComponents(stations_, links_, used_);
    ResetDatum(result.component, &result.survey_from_station);
    result.ambiguities = ambiguities_;
    result.moves = moves_;
    return result;
  }

  int stations_;
  std::span<const PoseGraphLink> links_;
  std::span<const LinkSupport> support_;
  SelectionOptions options_;
  std::vector<double> lead_;
  std::vector<std::vector<int>> rivals_;
  std::vector<char> eligible_;
  std::vector<char> used_;
  std::vector<char> barred_;  ///< links whose placement was tried and was no better
  std::vector<LinkFate> dropped_as_;
  std::vector<char> first_contradicted_;
  std::vector<RigidTransform> poses_;
  std::vector<Ambiguity> ambiguities_;
  int moves_ = 0;
};

}  // namespace

std::string ToString(LinkFate fate) {
  switch (fate) {
    case LinkFate::kUsed:
      return "";
    case LinkFate::kContradictsNetwork:
      return "contradicts_network";
    case LinkFate::kRivalWon:
      return "rival_won";
    case LinkFate::kUnconfirmed:
      return "unconfirmed";
    case LinkFate::kAmbiguous:
      return "ambiguous";
  }
  return "";
}

std::vector<char> LinkSelection::Used() const {
  std::vector<char> used;
  for (const LinkFate f : fate) used.push_back(f == LinkFate::kUsed ? 1 : 0);
  return used;
}

LinkSelection SelectLinks(int stations, std::span<const PoseGraphLink> links,
                          std::span<const LinkSupport> support, const SelectionOptions& options) {
  return Selector(stations, links, support, options).Select();
}

}  // namespace backsight
