#include "stages/misplaced_scanners.h"

#include <algorithm>

#include "core/median.h"
#include "stages/same_motion.h"

namespace backsight {
namespace {

constexpr std::size_t kFewestWays = 3;

/// One way to a station: where another station's pair with it puts it, and both scanners' views.
struct Way {
  int other_component = 0;
  RigidTransform survey_from_station;
  double by_station = 0.0;
  std::optional<double> by_other;
};

using Ways = std::vector<Way>;

/// By station, whether it is alone in its component.
std::vector<char> FindLonely(std::span<const int> component) {
  std::vector<char> lonely;
  for (const int c : component) {
    lonely.push_back(std::count(component.begin(), component.end(), c) == 1 ? 1 : 0);
  }
  return lonely;
}

/// Of every station that nothing is linked to, the ways that its own scanner, which nobody vouches
/// for, judges.
std::vector<Ways> CollectWays(std::span<const MutualView> views, const StationPlaces& places) {
  const std::vector<char> lonely = FindLonely(places.component);
  std::vector<Ways> ways(places.component.size());
  const auto add = [&](int station, int other, const RigidTransform& other_from_station,
                       const std::optional<double>& by_station,
                       const std::optional<double>& by_other) {
    const auto [s, o] =
        std::pair(static_cast<std::size_t>(station), static_cast<std::size_t>(other));
    if (!by_station || lonely[s] == 0 || places.scanner_assumed[s] == 0) return;
    ways[s].push_back({places.component[o], places.survey_from_station[o] * other_from_station,
                       *by_station, by_other});
  };
  for (const MutualView& view : views) {
    add(view.source, view.target, view.target_from_source, view.seen_through_by_source,
        view.seen_through_by_target);
    add(view.target, view.source, view.target_from_source.Inverse(), view.seen_through_by_target,
        view.seen_through_by_source);
  }
  return ways;
}

bool LeadAlike(const Way& a, const Way& b, double resolution_m) {
  return a.other_component == b.other_component &&
         IsSameMotion(a.survey_from_station, b.survey_from_station, resolution_m);
}

/// The most ways that lead to one place.
Ways LargestAgreement(const Ways& ways, double resolution_m) {
  Ways largest;
  for (const Way& center : ways) {
    Ways alike;
    std::copy_if(ways.begin(), ways.end(), std::back_inserter(alike),
                 [&](const Way& way) { return LeadAlike(center, way, resolution_m); });
    if (alike.size() > largest.size()) largest = std::move(alike);
  }
  return largest;
}

bool IsMisplaced(const Ways& ways, double contradiction) {
  if (ways.size() < kFewestWays) return false;
  std::vector<double> by_station;
  std::vector<double> by_others;
  for (const Way& way : ways) {
    by_station.push_back(way.by_station);
    if (way.by_other) by_others.push_back(*way.by_other);
  }
  // Where most other scans are not in their scanners' frames either, this one hardly is.
  const double allowed = 2 * by_others.size() >= ways.size() ? 0.5 : 1.0;
  const double seen_through = Median(std::move(by_station));
  return seen_through >= contradiction &&
         (by_others.empty() || Median(std::move(by_others)) < allowed * seen_through);
}

}  // namespace

std::optional<int> FindMisplacedScanner(std::span<const MutualView> views,
                                        const StationPlaces& places, double contradiction,
                                        double resolution_m) {
  const std::vector<Ways> ways = CollectWays(views, places);
  std::optional<int> clearest;
  std::size_t most = 0;
  for (std::size_t s = 0; s < ways.size(); ++s) {
    const Ways alike = LargestAgreement(ways[s], resolution_m);
    if (alike.size() <= most || !IsMisplaced(alike, contradiction)) continue;
    most = alike.size();
    clearest = static_cast<int>(s);
  }
  return clearest;
}

}  // namespace backsight
