#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "graph/rotation_sectors.h"
#include "graph/turn_measure.h"

namespace backsight {

struct StabbingResult {
  int count = 0;       ///< distinct ids at the best angle
  double angle = 0.0;  ///< middle of the first best segment, radians in [0, 2 pi)
};

/// The rotation that lies in the arcs of the most distinct ids (interval stabbing on the circle).
/// Ids are below `ids`, for which it keeps counters, and its memory from call to call.
class IntervalStabber {
 public:
  explicit IntervalStabber(std::size_t ids) : open_(ids, 0) {}

  /// Looks into `runs` only, ascending and apart from each other; exact where what lies outside
  /// gathers fewer than what it finds. Time O(n log n) for n arcs that end within a run.
  StabbingResult Stab(std::span<const TurnArc> arcs, std::span<const RotationSectors::Run> runs);

 private:
  /// An arc of key point `id` opens or closes at a turn. Keys ascend with the turn, and at equal
  /// turns what opens comes before what closes, so that touching arcs count together.
  struct Event {
    Event(double turn, bool closes, std::uint32_t its_id)
        : key(std::bit_cast<std::uint64_t>(turn) << 1U | (closes ? 1U : 0U)), id(its_id) {}
    double turn() const { return std::bit_cast<double>(key >> 1U); }  // never negative
    int step() const { return (key & 1U) != 0U ? -1 : +1; }
    std::uint64_t key;
    std::uint32_t id;
  };
  /// The best segment so far.
  struct Segment {
    int count = 0;
    double begin = 0.0, end = 0.0;
    bool is_open = false;
  };
  void Choose(std::span<const TurnArc> arcs, const RotationSectors::Run& run);
  int Enter(double begin, double end);
  void Add(double from, double to, double begin, double end, std::uint32_t id, int* count);

  std::vector<TurnArc> touching_;  // those of a run
  std::vector<Event> events_;      // within a run
  std::vector<int> open_;          // arcs of each id that are open; all zero between runs
};

}  // namespace backsight
