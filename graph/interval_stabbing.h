#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace backsight {

/// An interval of rotation angles, in radians, within which key point `id` is satisfied. May pass
/// 2 pi (end > 2 pi wraps around).
struct AngleInterval {
  double begin = 0.0;
  double end = 0.0;
  std::uint32_t id = 0;
};

struct StabbingResult {
  int count = 0;       ///< distinct ids at the best angle
  double angle = 0.0;  ///< middle of the first best segment, in [0, 2 pi)
};

/// The angle that lies in the intervals of the most distinct ids (interval stabbing on the circle).
/// Ids are below `ids`, for which it keeps counters, and its memory from call to call.
class IntervalStabber {
 public:
  explicit IntervalStabber(std::size_t ids) : open_(ids, 0) {}

  /// Time O(n log n).
  StabbingResult Stab(std::span<const AngleInterval> intervals);

 private:
  struct Event {
    double angle = 0.0;
    int step = 0;  // +1 opens, -1 closes
    std::uint32_t id = 0;
  };
  void MakeEvents(std::span<const AngleInterval> intervals);

  std::vector<Event> events_;
  std::vector<int> open_;  // intervals of each id that are open; all zero between calls
};

}  // namespace backsight
