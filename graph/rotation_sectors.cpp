#include "graph/rotation_sectors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace backsight {
namespace {

/// Grows with the direction's angle from 0 to 4 in a turn, by at most 1 per radian.
double PseudoAngle(double x, double y) {
  const double p = y / (std::abs(x) + std::abs(y));
  if (x < 0.0) return 2.0 - p;
  return p < 0.0 ? 4.0 + p : p;
}

/// The angle, radians, of a pseudo-angle from 0 to 4.
double AngleOf(double pseudo) {
  const double y = pseudo < 1.0 ? pseudo : pseudo < 3.0 ? 2.0 - pseudo : pseudo - 4.0;
  const double x = pseudo < 1.0 || pseudo > 3.0 ? 1.0 - std::abs(y) : std::abs(y) - 1.0;
  const double angle = std::atan2(y, x);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

/// No less than the arc cosine of `cosine`, by little where that is small:
/// acos(k) = 2 asin(x), x = sqrt((1 - k) / 2), and asin(x) <= x + (pi / 2 - 1) x^3.
double ArcCosineBound(double cosine) {
  const double x2 = std::max(0.5 * (1.0 - cosine), 0.0);
  return 2.0 * std::sqrt(x2) * (1.0 + 0.571 * x2);
}

}  // namespace

RotationSectors::Range RotationSectors::RangeOf(double x, double y, double cosine) {
  constexpr double kPerUnit = kCount / 4.0;
  constexpr double kRounding = 1e-7;
  const double half = ArcCosineBound(cosine) + kRounding;
  if (half > 1.0) return {};
  const double center = PseudoAngle(x, y);
  const auto sector = [&](double angle) {
    return static_cast<std::uint32_t>((angle + 4.0) * kPerUnit) % kCount;
  };
  return {sector(center - half), sector(center + half)};
}

double RotationSectors::BeginOf(std::size_t sector) {
  if (sector == kCount) return 2.0 * std::numbers::pi;
  return AngleOf(4.0 * static_cast<double>(sector) / kCount);
}

void RotationSectors::Add(const Range& range) {
  ++changes_[range.first];
  --changes_[range.last + 1];
  if (range.wraps()) ++changes_[0];
}

void RotationSectors::Count() {
  std::partial_sum(changes_.begin(), changes_.end() - 1, counts_.begin());
}

double RotationSectors::PeakAngle() const {
  const auto peak = std::max_element(counts_.begin(), counts_.end());
  const auto end = std::find_if(peak, counts_.end(), [&](int n) { return n != *peak; });
  return 0.5 * (BeginOf(static_cast<std::size_t>(peak - counts_.begin())) +
                BeginOf(static_cast<std::size_t>(end - counts_.begin())));
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
