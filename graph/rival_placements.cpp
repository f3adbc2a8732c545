#include "graph/rival_placements.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "graph/cycle_consistency.h"
#include "graph/graph_connectivity.h"

namespace backsight {
namespace {

/// An unused link, and by what it would displace its source.
struct Rival {
  int link;
  Matrix6d covariance;
  RigidTransform displacement;
  double rotation_variance;
};

/// An unused link read as "move `mover` and leave `other`".
struct Demand {
  int link;
  int mover;
  int other;
};

/// What moving one end of a pair and not the other would break and fulfil.
struct Vote {
  int used = -1;   ///< link that would break
  int rival = -1;  ///< link that would be fulfilled
};

/// Votes of one displacement by (moved station, station left).
using Votes = std::map<std::pair<int, int>, Vote>;

/// The best placement so far, and the used links across any undecided one.
struct Search {
  std::optional<RivalPlacement> best;
  std::set<int> suspects;
};

class Finder {
 public:
  Finder(std::span<const PoseGraphLink> links, std::span<const char> eligible,
         std::span<const char> used, std::span<const RigidTransform> poses,
         const RivalOptions& options)
      : links_(links), used_(used), poses_(poses), options_(options) {
    const int stations = static_cast<int>(poses.size());
    component_ = FindComponents(stations, links, used);
    bridges_ = FindBridges(stations, links, used);
    std::vector<char> held_twice(used.begin(), used.end());
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (bridges_[l] != 0) held_twice[l] = 0;
    }
    rigid_part_ = FindComponents(stations, links, held_twice);
    for (std::size_t l = 0; l < links.size(); ++l) {
      if (used[l] != 0) {
        neighbours_[links[l].source].push_back(static_cast<int>(l));
        neighbours_[links[l].target].push_back(static_cast<int>(l));
      }
      if (eligible[l] == 0 || used[l] != 0) continue;
      const PoseGraphLink& link = links[l];
      if (At(component_, link.source) != At(component_, link.target)) continue;
      if (backsight::SquaredError(link, poses) <= options.limit || IsSamePlace(link)) continue;
      if (link.credibility == 0.0 && !RivalOfUsed(link)) continue;
      const Matrix6d covariance = CovarianceOf(link.information);
      rivals_.push_back({static_cast<int>(l), covariance,
                         Pose(link.target) * link.target_from_source * Pose(link.source).Inverse(),
                         covariance.topLeftCorner<3, 3>().trace()});
    }
  }

  std::vector<RivalPlacement> Find() {
    std::vector<RivalPlacement> found;
    std::vector<char> done(links_.size(), 0);
    for (const Rival& rival : rivals_) {
      if (done[static_cast<std::size_t>(rival.link)] != 0) continue;
      const PoseGraphLink& link = Link(rival.link);
      const std::vector<Demand> demands = SameDisplacement(rival);
      for (const Demand& demand : demands) done[static_cast<std::size_t>(demand.link)] = 1;
      const bool alone = std::all_of(demands.begin(), demands.end(), [&](const Demand& demand) {
        return demand.link == rival.link;
      });
      if (alone && At(rigid_part_, link.source) == At(rigid_part_, link.target)) continue;
      std::optional<RivalPlacement> best = alone ? LoneSet(rival) : BestSet(rival, demands);
      if (best) found.push_back(std::move(*best));
    }
    return found;
  }

 private:
  template <typename T>
  static const T& At(const std::vector<T>& values, int k) {
    return values[static_cast<std::size_t>(k)];
  }
  const PoseGraphLink& Link(int l) const { return links_[static_cast<std::size_t>(l)]; }
  const RigidTransform& Pose(int s) const { return poses_[static_cast<std::size_t>(s)]; }

  bool RivalOfUsed(const PoseGraphLink& link) const {
    for (std::size_t l = 0; l < links_.size(); ++l) {
      if (used_[l] != 0 && links_[l].pair >= 0 && links_[l].pair == link.pair) return true;
    }
    return false;
  }
  bool IsSamePlace(const PoseGraphLink& link) const {
    const Vector6d residual = LinkResidual(link, Pose(link.source), Pose(link.target));
    return residual.head<3>().norm() < options_.least_turn_rad &&
           residual.tail<3>().norm() < options_.least_shift_m;
  }

  /// All rivals that the displacement of `seed` fulfils if it moves one of their ends.
  std::vector<Demand> SameDisplacement(const Rival& seed) const {
    const PoseGraphLink& asked = Link(seed.link);
    const RigidTransform& displacement = seed.displacement;
    const Matrix6d to_survey = Adjoint(Pose(asked.target));
    const Matrix6d uncertainty = to_survey * seed.covariance * to_survey.transpose();
    std::vector<Demand> demands;
    for (const Rival& rival : rivals_) {
      const PoseGraphLink& link = Link(rival.link);
      if (At(component_, link.source) != At(component_, asked.source)) continue;
      for (const bool source_moves : {true, false}) {
        // Implied by the full test below and much cheaper: the squared distance of two rotation
        // matrices is at most twice the squared angle between them.
        const double apart =
            (displacement.rotation -
             (source_moves ? rival.displacement.rotation : rival.displacement.rotation.transpose()))
                .squaredNorm();
        if (apart > 2.0 * options_.limit * (rival.rotation_variance + seed.rotation_variance)) {
          continue;
        }
        const RigidTransform source =
            source_moves ? displacement * Pose(link.source) : Pose(link.source);
        const RigidTransform target =
            source_moves ? Pose(link.target) : displacement * Pose(link.target);
        const Vector6d residual = LinkResidual(link, source, target);
        const Matrix6d to_link = Adjoint(target.Inverse());
        const Matrix6d covariance = rival.covariance + to_link * uncertainty * to_link.transpose();
        if (residual.dot(covariance.ldlt().solve(residual)) > options_.limit) continue;
        demands.push_back({rival.link, source_moves ? link.source : link.target,
                           source_moves ? link.target : link.source});
      }
    }
    return demands;
  }

  double Weigh(const Vote& vote) const {
    const auto full = [&](int l) {
      return Link(l).credibility * (Link(l).doubtful ? 0.5 * kFullVote : kFullVote);
    };
    if (vote.rival < 0) return full(vote.used);
    if (vote.used < 0) return -full(vote.rival);
    // Links of two pairs between the same stations are two statements.
    if (Link(vote.used).pair < 0 || Link(vote.used).pair != Link(vote.rival).pair) {
      return full(vote.used) - full(vote.rival);
    }
    const double difference = Link(vote.used).score - Link(vote.rival).score;
    return std::clamp(difference / (std::numbers::sqrt2 * options_.score_noise), -kFullVote,
                      kFullVote);
  }

  Votes CollectVotes(const std::vector<Demand>& demands, int component) const {
    Votes votes;
    for (const auto& [station, own] : neighbours_) {
      if (At(component_, station) != component) continue;
      for (const int l : own) {
        const int other = Link(l).source == station ? Link(l).target : Link(l).source;
        votes[{station, other}].used = l;
      }
    }
    for (const Demand& demand : demands) votes[{demand.mover, demand.other}].rival = demand.link;
    return votes;
  }

  /// A rival that no other agrees with stands against each single link that holds its ends
  /// together.
  std::optional<RivalPlacement> LoneSet(const Rival& rival) const {
    const PoseGraphLink& link = Link(rival.link);
    if (link.doubtful && link.credibility < kLeastCredibility) return std::nullopt;
    const Votes votes =
        CollectVotes({{rival.link, link.source, link.target}}, At(component_, link.source));
    Search search;
    for (std::size_t b = 0; b < links_.size(); ++b) {
      if (bridges_[b] == 0) continue;
      std::vector<char> without(used_.begin(), used_.end());
      without[b] = 0;
      const std::vector<int> part =
          FindComponents(static_cast<int>(poses_.size()), links_, without);
      if (At(part, link.source) == At(part, link.target)) continue;
      std::vector<char> inside;
      inside.reserve(part.size());
      for (const int p : part) inside.push_back(p == At(part, link.source) ? 1 : 0);
      Consider(votes, inside, &search);
    }
    return Conclude(rival, votes, std::move(search));
  }

  std::optional<RivalPlacement> BestSet(const Rival& rival,
                                        const std::vector<Demand>& demands) const {
    const Votes votes = CollectVotes(demands, At(component_, demands.front().mover));
    Search search;
    for (const Demand& demand : demands) {
      Grow(votes, demand, true, &search);
      Grow(votes, demand, false, &search);
    }
    return Conclude(rival, votes, std::move(search));
  }

  static std::optional<RivalPlacement> Conclude(const Rival& rival, const Votes& votes,
                                                Search search) {
    if (!search.best) return std::nullopt;
    search.best->displacement = rival.displacement;
    std::set<int> with_rival;
    for (const auto& [ends, vote] : votes) {
      if (vote.used >= 0 && vote.rival >= 0) with_rival.insert(vote.rival);
    }
    const auto& speaking = search.best->links;
    if (std::any_of(speaking.begin(), speaking.end(),
                    [&](int l) { return !with_rival.contains(l); })) {
      search.best->suspects.assign(search.suspects.begin(), search.suspects.end());
    }
    return std::move(search.best);
  }

  /// Adds stations to the mover's side, never `other`, in order of the margin they leave; or
  /// (`movers` false) to the other's side, never the mover.
  void Grow(const Votes& votes, const Demand& demand, bool movers, Search* search) const {
    std::map<int, double> change;  // of the margin, by adding a station to the side
    std::vector<char> inside(poses_.size(), 0);
    for (const auto& [ends, vote] : votes) {
      change[movers ? ends.first : ends.second] += Weigh(vote);
      change[movers ? ends.second : ends.first] += 0.0;
    }
    if (!movers) {
      for (const auto& [station, delta] : change) inside[static_cast<std::size_t>(station)] = 1;
    }
    const int never = movers ? demand.other : demand.mover;
    int next = movers ? demand.mover : demand.other;
    while (next >= 0) {
      change.erase(next);
      inside[static_cast<std::size_t>(next)] = movers ? 1 : 0;
      Consider(votes, inside, search);
      for (auto& [station, delta] : change) {
        // What runs between the station and `next` would no longer be cut.
        for (const std::pair<int, int>& ends : {std::pair{station, next}, {next, station}}) {
          const auto vote = votes.find(ends);
          if (vote != votes.end()) delta -= Weigh(vote->second);
        }
      }
      next = -1;
      for (const auto& [station, delta] : change) {
        if (station != never && (next < 0 || delta < change[next])) next = station;
      }
    }
  }

  /// Weighs the placement that moves the stations `inside`.
  void Consider(const Votes& votes, const std::vector<char>& inside, Search* search) const {
    RivalPlacement placement;
    double variance = 0.0;
    for (const auto& [ends, vote] : votes) {
      if (At(inside, ends.first) == 0 || At(inside, ends.second) != 0) continue;
      placement.margin += Weigh(vote);
      variance += vote.used >= 0 && vote.rival >= 0
                      ? 1.0
                      : 2.0 * Link(std::max(vote.used, vote.rival)).credibility;
      if (vote.used >= 0) placement.suspects.push_back(vote.used);
      if (vote.rival >= 0) placement.links.push_back(vote.rival);
    }
    placement.kept = static_cast<int>(placement.suspects.size());
    if (placement.links.size() < 2 && placement.kept > 1) return;
    placement.noise = 3.0 * std::sqrt(variance);
    if (placement.Undecided()) {
      search->suspects.insert(placement.suspects.begin(), placement.suspects.end());
    }
    std::optional<RivalPlacement>& best = search->best;
    if (best && best->margin - best->noise <= placement.margin - placement.noise) return;
    for (std::size_t s = 0; s < inside.size(); ++s) {
      if (inside[s] != 0) placement.stations.push_back(static_cast<int>(s));
    }
    best = std::move(placement);
  }

  std::span<const PoseGraphLink> links_;
  std::span<const char> used_;
  std::span<const RigidTransform> poses_;
  RivalOptions options_;
  std::vector<int> component_;
  std::vector<char> bridges_;
  std::vector<int> rigid_part_;  ///< stations that no single used link holds together
  std::vector<Rival> rivals_;
  std::map<int, std::vector<int>> neighbours_;  ///< used links by station
};

}  // namespace

std::vector<RivalPlacement> FindRivalPlacements(std::span<const PoseGraphLink> links,
                                                std::span<const char> eligible,
                                                std::span<const char> used,
                                                std::span<const RigidTransform> poses,
                                                const RivalOptions& options) {
  return Finder(links, eligible, used, poses, options).Find();
}

}  // namespace backsight
