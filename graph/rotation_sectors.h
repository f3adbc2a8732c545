#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace backsight {

/// The circle of rotation angles cut into sectors, and how many intervals of angles touch each: no
/// angle in a sector lies in more. Sectors are equal in a measure that needs no arc tangent; the
/// widest are 1.27 times as wide as the mean.
class RotationSectors {
 public:
  static constexpr std::uint32_t kCount = 512;

  /// Sectors from `first` round to `last`; all of them where nothing else is known.
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t last = kCount - 1;
    bool wraps() const { return first > last; }
    /// Whether any sector in [begin, end) is in it.
    bool Touches(std::size_t begin, std::size_t end) const {
      return wraps() ? first < end || last >= begin : first < end && last >= begin;
    }
  };
  /// The sectors of all angles whose difference from the direction (x, y) has a cosine of at least
  /// `cosine`, and maybe the next ones; all where that is half a turn or nearly so.
  static Range RangeOf(double x, double y, double cosine);
  /// Where a sector begins, radians in [0, 2 pi]; kCount is the end of the last.
  static double BeginOf(std::size_t sector);

  void Clear() { changes_.fill(0); }
  void Add(const Range& range);
  /// Ends adding.
  void Count();

  /// The middle of the first run of fullest sectors, radians.
  double PeakAngle() const;
  /// Sectors [begin, end) side by side with more than `bar`.
  struct Run {
    std::size_t begin, end;
  };
  const std::vector<Run>& RunsAbove(int bar);

 private:
  std::array<int, kCount + 1> changes_{};
  std::array<int, kCount> counts_{};
  std::vector<Run> runs_;
};

}  // namespace backsight
