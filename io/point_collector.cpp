#include "io/point_collector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace backsight {

std::uint16_t ScaleColor(double value, ColorScale scale) {
  const double factor =
      scale == ColorScale::k8Bit ? 257.0 : (scale == ColorScale::kUnit ? 65535.0 : 1.0);
  const double scaled = std::round(value * factor);
  if (!(scaled > 0.0)) return 0;  // NaN too
  return static_cast<std::uint16_t>(std::min(scaled, 65535.0));
}

bool PointCollector::AddPoint(double x, double y, double z, PointChunk& chunk) {
  ++tally_.records;
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
    ++tally_.not_finite;
    return false;
  }
  if (structured_ && x == 0.0 && y == 0.0 && z == 0.0) {
    ++tally_.no_return;
    return false;
  }
  ++tally_.points;
  chunk.x.push_back(x);
  chunk.y.push_back(y);
  chunk.z.push_back(z);
  return true;
}

void PointCollector::AddIntensity(double raw, PointChunk& chunk) {
  double value = (raw - range_.low) / (range_.high - range_.low);
  if (!(value >= 0.0 && value <= 1.0)) {
    ++clamped_;
    value = value > 1.0 ? 1.0 : 0.0;  // NaN becomes dark
  }
  chunk.intensity.push_back(static_cast<float>(value));
}

void PointCollector::Finish() {
  if (clamped_ == 0) return;
  tally_.notes.push_back(fmt::format("intensity outside {} to {} clamped in {} of {} points",
                                     range_.low, range_.high, clamped_, tally_.points));
}

}  // namespace backsight
