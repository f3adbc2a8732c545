#include "graph/rotation_sectors.h"

#include <algorithm>

namespace backsight {

double RotationSectors::AngleBefore(std::size_t sector) {
  static const auto kAngles = [] {
    std::array<double, kCount + 1> angles{};
    for (std::size_t i = 0; i <= kCount; ++i) angles[i] = AngleOf(Run{i, i}.begin_turn());
    return angles;
  }();
  return kAngles[sector];
}

int RotationSectors::Count() {
  int count = 0;
  for (std::size_t sector = 0; sector < kCount; ++sector) {
    count += changes_[sector];
    counts_[sector] = count;
  }
  int most = 0;  // by itself: compilers take several at a time
  for (const int n : counts_) most = std::max(most, n);
  most_ = most;
  return most_;
}

double RotationSectors::PeakTurn() const {
  const auto peak = std::find(counts_.begin(), counts_.end(), most_);
  const auto end = std::find_if(peak, counts_.end(), [&](int n) { return n != most_; });
  const Run run{static_cast<std::size_t>(peak - counts_.begin()),
                static_cast<std::size_t>(end - counts_.begin())};
  return 0.5 * (run.begin_turn() + run.end_turn());
}

const std::vector<RotationSectors::Run>& RotationSectors::RunsAbove(int bar) {
  runs_.clear();
  for (std::size_t begin = 0; begin < kCount; ++begin) {
    if (counts_[begin] <= bar) continue;
    std::size_t end = begin + 1;
    while (end < kCount && counts_[end] > bar) ++end;
    runs_.push_back({begin, end});
    begin = end;
  }
  return runs_;
}

}  // namespace backsight
