#include "graph/interval_stabbing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace backsight {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

void IntervalStabber::MakeEvents(std::span<const AngleInterval> intervals) {
  events_.clear();
  const auto add = [&](double begin, double end, std::uint32_t id) {
    events_.push_back({begin, +1, id});
    events_.push_back({end, -1, id});
  };
  for (const AngleInterval& interval : intervals) {
    const double width = interval.end - interval.begin;
    if (width >= kTurn) {
      add(0.0, kTurn, interval.id);
      continue;
    }
    const double begin = interval.begin - kTurn * std::floor(interval.begin / kTurn);
    if (begin + width < kTurn) {
      add(begin, begin + width, interval.id);
    } else {  // wraps, or touches what begins at 0: cut at the full turn
      add(begin, kTurn, interval.id);
      add(0.0, begin + width - kTurn, interval.id);
    }
  }
}

StabbingResult IntervalStabber::Stab(std::span<const AngleInterval> intervals) {
  MakeEvents(intervals);
  // Opens before closes at equal angles, so that touching intervals count together.
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return a.angle != b.angle ? a.angle < b.angle : a.step > b.step;
  });
  StabbingResult best;
  int count = 0;
  double changed = 0.0;           // where count took its present value
  double begin = 0.0, end = 0.0;  // of the best segment
  bool in_best = false;
  double tail_begin = 0.0;  // of the segment that ends at the cut
  int tail_count = -1;
  for (const Event& event : events_) {
    if (event.angle >= kTurn && tail_count < 0) {
      tail_begin = changed;
      tail_count = count;
    }
    int& depth = open_[event.id];
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
