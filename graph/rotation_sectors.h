#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "graph/turn_measure.h"

namespace backsight {

/// The circle of rotations cut into sectors that are equal in TurnOf, and how many arcs touch each:
/// no rotation in a sector lies in more. The widest are 1.27 times as wide as the mean.
class RotationSectors {
 public:
  static constexpr std::uint32_t kCount = 512;

  /// Radians from the first sector's begin to a sector's, or, with kCount, all round.
  static double AngleBefore(std::size_t sector);

  /// Sectors [begin, end) side by side.
  struct Run {
    std::size_t begin, end;
    double begin_turn() const { return kFullTurn * static_cast<double>(begin) / kCount; }
    double end_turn() const { return kFullTurn * static_cast<double>(end) / kCount; }
    double begin_angle() const { return AngleBefore(begin); }  ///< radians
    double end_angle() const { return AngleBefore(end); }
    bool Touches(const TurnArc& arc) const {
      const double begin_at = begin_turn();
      const int before_end = arc.begin <= end_turn() ? 1 : 0;
      const int after_begin = arc.end >= begin_at ? 1 : 0;
      const int once_more = arc.end >= kFullTurn + begin_at ? 1 : 0;
      return ((before_end & after_begin) | once_more) != 0;  // without branches
    }
  };

  void Clear() { changes_.fill(0); }
  void Add(const TurnArc& arc) {
    constexpr double kPerTurn = kCount / kFullTurn;
    const bool wraps = arc.end >= kFullTurn;
    const auto first = static_cast<std::uint32_t>(arc.begin * kPerTurn);
    const auto last =
        static_cast<std::uint32_t>((wraps ? arc.end - kFullTurn : arc.end) * kPerTurn);
    const int is_all = static_cast<int>(wraps) & static_cast<int>(last >= first);
    changes_[first] += 1 - is_all;  // without branches: arcs follow no pattern
    changes_[last + 1] -= 1 - is_all;
    changes_[0] += static_cast<int>(wraps);
  }
  /// Ends adding. Returns the most arcs that touch one sector.
  int Count();

  /// How many arcs touch a sector.
  int ArcsIn(std::size_t sector) const { return counts_[sector]; }
  /// The middle of the first run of fullest sectors.
  double PeakTurn() const;
  /// Runs of sectors with more than `bar`, ascending.
  const std::vector<Run>& RunsAbove(int bar);

 private:
  std::array<int, kCount + 1> changes_{};
  std::array<int, kCount> counts_{};
  int most_ = 0;
  std::vector<Run> runs_;
};

}  // namespace backsight
