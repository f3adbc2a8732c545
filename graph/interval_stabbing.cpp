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
    if (begin + width < kTurn) {
      add(begin, begin + width, slot);
    } else {  // wraps, or touches what begins at 0: cut at the full turn
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
  double changed = 0.0;           // where count took its present value
  double begin = 0.0, end = 0.0;  // of the best segment
  bool in_best = false;
  double tail_begin = 0.0;  // of the segment that ends at the cut
  int tail_count = -1;
  for (const Event& event : events) {
    if (event.angle >= kTurn && tail_count < 0) {
      tail_begin = changed;
      tail_count = count;
    }
    int& depth = open[event.slot];
    depth += event.step;
    const bool opens = event.step > 0 && depth == 1;
    const bool closes = event.step < 0 && depth == 0;
    if (!opens && !closes) continue;
    count += event.step;
    changed = event.angle;
    if (count > best.count) {
      best.count = count;
      begin = event.angle;
      in_best = true;
    } else if (closes && in_best) {
      end = event.angle;
      in_best = false;
    }
  }
  // The best segment may begin before the cut.
  if (begin == 0.0 && tail_count == best.count && tail_begin > 0.0) begin = tail_begin - kTurn;
  best.angle = 0.5 * (begin + end);
  if (best.angle < 0.0) best.angle += kTurn;
  if (best.angle >= kTurn) best.angle -= kTurn;
  return best;
}

}  // namespace backsight
