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

void PointCollector::AddCell(double row, double column, const ScanInfo& grid, PointChunk& chunk) {
  const auto inside = [](double index, int side) { return index >= 0.0 && index < side; };
  const auto nearest = [](double index, int side) {
    const double last = side - 1;
    return static_cast<std::int32_t>(index > 0.0 ? std::min(index, last) : 0.0);  // NaN: 0
  };
  if (!inside(row, grid.rows) || !inside(column, grid.columns)) ++outside_grid_;
  chunk.row.push_back(nearest(row, grid.rows));
  chunk.column.push_back(nearest(column, grid.columns));
}

PointCollector PointCollector::ForPart() const {
  PointCollector part;
  part.Configure(structured_, range_);
  return part;
}

void PointCollector::Add(const PointCollector& part) {
  tally_.records += part.tally_.records;
  tally_.points += part.tally_.points;
  tally_.not_finite += part.tally_.not_finite;
  tally_.no_return += part.tally_.no_return;
  tally_.withheld += part.tally_.withheld;
  clamped_ += part.clamped_;
  outside_grid_ += part.outside_grid_;
}

void PointCollector::Finish() {
  if (clamped_ > 0) {
    tally_.notes.push_back(fmt::format("intensity outside {} to {} clamped in {} of {} points",
                                       range_.low, range_.high, clamped_, tally_.points));
  }
  if (outside_grid_ > 0) {
    tally_.notes.push_back(
        fmt::format("row or column outside the scan grid, moved to its edge, in "
                    "{} of {} points",
                    outside_grid_, tally_.points));
  }
}

}  // namespace backsight
