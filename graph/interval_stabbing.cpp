#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <vector>

#include "graph/edge_consensus.h"

namespace backsight {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

struct Event {
  double angle = 0.0;
  int step = 0;  // +1 opens, -1 closes
  std::size_t slot = 0;
};

/// Opens before closes at equal angles, so that touching intervals count together.
bool Before(const Event& a, const Event& b) {
  return a.angle != b.angle ? a.angle < b.angle : a.step > b.step;
}

std::vector<Event> MakeEvents(std::span<const AngleInterval> intervals, std::size_t* slots) {
  std::unordered_map<std::uint32_t, std::size_t> slot_of_id;
  std::vector<Event> events;
  events.reserve(4 * intervals.size());
  const auto add = [&](double begin, double end, std::size_t slot) {
    events.push_back({begin, +1, slot});
    events.push_back({end, -1, slot});
  };
  for (const AngleInterval& interval : intervals) {
    const std::size_t slot = slot_of_id.try_emplace(interval.id, slot_of_id.size()).first->second;
    const double width = interval.end - interval.begin;
    if (width >= kTurn) {
      add(0.0, kTurn, slot);
      continue;
    }
    const double begin = interval.begin - kTurn * std::floor(interval.begin / kTurn);
    if (begin + width <= kTurn) {
      add(begin, begin + width, slot);
    } else {  // wraps: cut at the full turn
      add(begin, kTurn, slot);
      add(0.0, begin + width - kTurn, slot);
    }
  }
  *slots = slot_of_id.size();
  return events;
}

}  // namespace

StabbingResult StabIntervals(std::span<const AngleInterval> intervals) {
  std::size_t slots = 0;
  std::vector<Event> events = MakeEvents(intervals, &slots);
  std::sort(events.begin(), events.end(), Before);

  std::vector<int> open(slots, 0);
  StabbingResult best;
  int count = 0;
  for (std::size_t e = 0; e < events.size(); ++e) {
    int& depth = open[events[e].slot];
    if (events[e].step > 0) {
      if (++depth == 1) ++count;
      if (count > best.count) {
        best.count = count;
        best.angle = 0.5 * (events[e].angle + events[e + 1].angle);
      }
    } else if (--depth == 0) {
      --count;
    }
  }
  if (best.angle >= kTurn) best.angle -= kTurn;
  return best;
}

}  // namespace backsight
