#include "io/xyz_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace backsight {
namespace {

using Sample = std::span<const std::vector<double>>;

/// Values that a column takes in the sample.
struct ColumnRange {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  bool whole_numbers = true;

  bool IsWholeWithin(double low, double high) const {
    return whole_numbers && min >= low && max <= high;
  }
};

ColumnRange RangeOf(Sample sample, std::size_t column) {
  ColumnRange range;
  for (const std::vector<double>& line : sample) {
    const double value = line[column];
    range.min = std::min(range.min, value);
    range.max = std::max(range.max, value);
    range.whole_numbers = range.whole_numbers && std::floor(value) == value;
  }
  return range;
}

bool IsColor(Sample sample, std::size_t first) {
  for (std::size_t i = first; i < first + 3; ++i) {
    if (!RangeOf(sample, i).IsWholeWithin(0.0, 65535.0)) return false;
  }
  return true;
}

ColorScale ColorScaleOf(Sample sample, const std::array<std::size_t, 3>& rgb) {
  ColorScale scale = ColorScale::k8Bit;
  for (const std::size_t column : rgb) {
    const ColumnRange range = RangeOf(sample, column);
    if (!range.whole_numbers && range.min >= 0.0 && range.max <= 1.0) return ColorScale::kUnit;
    if (range.max > 255.0) scale = ColorScale::k16Bit;
  }
  return scale;
}

IntensityRange GuessIntensityRange(const ColumnRange& range, bool is_pts) {
  if (range.min >= 0.0 && range.max <= 1.0) return {0.0, 1.0};
  if (range.min < 0.0 && range.min >= -2048.0 && range.max <= 2047.0) return {-2048.0, 2047.0};
  if (range.min >= 0.0 && range.max <= 255.0) return {0.0, 255.0};
  if (is_pts && range.min >= -2048.0 && range.max <= 2047.0) return {-2048.0, 2047.0};
  if (range.min >= 0.0 && range.max <= 65535.0) return {0.0, 65535.0};
  return {range.min, std::max(range.max, range.min + 1.0)};
}

void UseValues(Sample sample, XyzLayout& layout) {
  const auto color_at = [&](std::size_t first) { layout.rgb = {first, first + 1, first + 2}; };
  if (layout.columns == 4 || layout.columns == 5) {
    layout.intensity = 3;
  } else if (layout.columns >= 7 && IsColor(sample, 4)) {
    layout.intensity = 3;
    color_at(4);
  } else if (layout.columns >= 6 && IsColor(sample, 3)) {
    color_at(3);
    if (layout.columns >= 7) layout.intensity = 6;
  } else if (layout.columns == 7) {
    layout.intensity = 3;
  }
}

void GuessRanges(Sample sample, bool is_pts, XyzLayout& layout) {
  if (layout.HasIntensity()) {
    layout.intensity_range = GuessIntensityRange(RangeOf(sample, layout.intensity), is_pts);
  }
  if (layout.HasRgb()) layout.color_scale = ColorScaleOf(sample, layout.rgb);
}

}  // namespace

std::string XyzLayout::Describe() const {
  std::vector<std::string> names(columns, "(skipped)");
  names[xyz[0]] = std::string("x");
  names[xyz[1]] = std::string("y");
  names[xyz[2]] = std::string("z");
  if (HasIntensity()) {
    names[intensity] =
        fmt::format("intensity({} to {})", intensity_range.low, intensity_range.high);
  }
  if (HasRgb()) {
    const char* top = color_scale == ColorScale::k8Bit
                          ? "255"
                          : (color_scale == ColorScale::k16Bit ? "65535" : "1");
    names[rgb[0]] = fmt::format("red(0 to {})", top);
    names[rgb[1]] = fmt::format("green(0 to {})", top);
    names[rgb[2]] = fmt::format("blue(0 to {})", top);
  }
  return fmt::format("columns: {}", fmt::join(names, " "));
}

XyzLayout GuessXyzLayout(std::span<const std::vector<double>> sample, bool is_pts) {
  XyzLayout layout;
  layout.columns = sample.front().size();
  UseValues(sample, layout);
  GuessRanges(sample, is_pts, layout);
  return layout;
}

XyzLayout GivenXyzLayout(const TextColumns& columns, std::span<const std::vector<double>> sample,
                         bool is_pts) {
  const auto place = [&](TextColumn column) {
    const auto found = std::find(columns.begin(), columns.end(), column);
    return found == columns.end() ? XyzLayout::kNone
                                  : static_cast<std::size_t>(found - columns.begin());
  };
  XyzLayout layout;
  layout.columns = columns.size();
  layout.xyz = {place(TextColumn::kX), place(TextColumn::kY), place(TextColumn::kZ)};
  layout.intensity = place(TextColumn::kIntensity);
  layout.rgb = {place(TextColumn::kRed), place(TextColumn::kGreen), place(TextColumn::kBlue)};
  GuessRanges(sample, is_pts, layout);
  return layout;
}

}  // namespace backsight
