#include "graph/rotation_sectors.h"

#include <algorithm>

namespace backsight {

/// Block by block, whose sums do not wait for each other.
int RotationSectors::Count() {
  constexpr std::size_t kBlock = 16;
  static_assert(kCount % kBlock == 0);
  most_ = 0;
  int before = 0;
  for (std::size_t begin = 0; begin < kCount; begin += kBlock) {
    std::array<int, kBlock> sums;
    int sum = 0;
    for (std::size_t i = 0; i < kBlock; ++i) sums[i] = sum += changes_[begin + i];
    int most = 0;
    for (std::size_t i = 0; i < kBlock; ++i) {
      counts_[begin + i] = before + sums[i];
      most = std::max(most, counts_[begin + i]);
    }
    most_ = std::max(most_, most);
    before += sum;
  }
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
