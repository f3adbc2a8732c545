#include "graph/interval_stabbing.h"

#include <algorithm>
#include <numbers>

namespace backsight {

/// The part of the arc piece [from, to] in the run from `begin` to `end`: open from the run's begin
/// on, or from an event.
void IntervalStabber::Add(double from, double to, double begin, double end, std::uint32_t id,
                          int* count) {
  if (from > end || to < begin) return;
  if (from <= begin) {
    if (++open_[id] == 1) ++*count;
  } else {
    events_.emplace_back(from, /*closes=*/false, id);
  }
  if (to < end) events_.emplace_back(to, /*closes=*/true, id);
}

/// The arcs that touch the run, without branches: they follow no pattern.
void IntervalStabber::Choose(std::span<const TurnArc> arcs, const RotationSectors::Run& run) {
  touching_.resize(arcs.size());
  std::size_t count = 0;
  for (const TurnArc& arc : arcs) {
    touching_[count] = arc;
    count += run.Touches(arc) ? 1U : 0U;
  }
  touching_.resize(count);
}

/// Sets the events of a run that begins and ends there; returns how many ids are open where it
/// begins.
int IntervalStabber::Enter(double begin, double end) {
  events_.clear();
  int count = 0;
  for (const TurnArc& arc : touching_) {
    if (arc.end < kFullTurn || arc.begin == 0.0) {
      Add(arc.begin, std::min(arc.end, kFullTurn), begin, end, arc.id, &count);
    } else {  // passes the full turn, or touches what begins at 0: cut there
      Add(arc.begin, kFullTurn, begin, end, arc.id, &count);
      Add(0.0, arc.end - kFullTurn, begin, end, arc.id, &count);
    }
  }
  std::sort(events_.begin(), events_.end(),
            [](const Event& a, const Event& b) { return a.key < b.key; });
  return count;
}

StabbingResult IntervalStabber::Stab(std::span<const TurnArc> arcs,
                                     std::span<const RotationSectors::Run> runs) {
  Segment best;
  double tail_begin = 0.0;  // of the segment that ends at the full turn
  int tail_count = -1;
  for (const RotationSectors::Run& run : runs) {
    const double end = run.end_turn();
    double changed = run.begin_turn();  // where count took its present value
    Choose(arcs, run);
    int count = Enter(changed, end);
    if (count > best.count) best = {count, changed, end, true};
    for (const Event& event : events_) {
      int& depth = open_[event.id];
      const int step = event.step();
      depth += step;
      const bool opens = step > 0 && depth == 1;
      const bool closes = step < 0 && depth == 0;
      if (!opens && !closes) continue;
      count += step;
      changed = event.turn();
      if (count > best.count) {
        best = {count, changed, end, true};
      } else if (closes && best.is_open) {
        best.end = changed;
        best.is_open = false;
      }
    }
    best.is_open = false;
    if (end == kFullTurn) tail_begin = changed, tail_count = count;
    for (const TurnArc& arc : touching_) open_[arc.id] = 0;
  }
  StabbingResult result;
  result.count = best.count;
  double begin = AngleOf(best.begin);
  // The best segment may begin before the cut.
  if (best.begin == 0.0 && tail_count == best.count && tail_begin > 0.0) {
    begin = AngleOf(tail_begin) - 2.0 * std::numbers::pi;
  }
  result.angle = 0.5 * (begin + AngleOf(best.end));
  if (result.angle < 0.0) result.angle += 2.0 * std::numbers::pi;
  if (result.angle >= 2.0 * std::numbers::pi) result.angle -= 2.0 * std::numbers::pi;
  return result;
}

}  // namespace backsight
