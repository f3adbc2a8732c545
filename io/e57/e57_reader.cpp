#include "io/e57/e57_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "io/e57/e57_scan.h"
#include "io/e57/field_stream.h"
#include "io/point_collector.h"

namespace backsight {
namespace {

// The bytestreams of so many records rarely reach farther than to the next packet.
constexpr std::size_t kBatchRecords = 1024;

/// Decoded values of one field, a batch at a time.
struct Column {
  FieldStream stream;
  std::vector<double> values;
};

bool IsUsable(const E57Limits& limits) {
  return limits.high > limits.low && std::isfinite(limits.high - limits.low);
}

/// The limits of a quantity: what the scan states, else what its field can hold, else 0 to 1.
E57Limits LimitsOf(const std::optional<E57Limits>& stated, const E57Field& field) {
  if (stated && IsUsable(*stated)) return *stated;
  return IsUsable(field.limits) ? field.limits : E57Limits{0.0, 1.0};
}

std::uint16_t ColorOf(double value, const E57Limits& limits) {
  return ScaleColor((value - limits.low) / (limits.high - limits.low), ColorScale::kUnit);
}

class E57Reader : public ScanReader {
 public:
  E57Reader(const std::string& path, int scan_index)
      : file_(path),
        scan_(ReadE57Scan(file_, scan_index)),
        section_(file_, scan_.points, scan_.fields) {
    FillInfo(scan_index);
    MapCoordinates();
    MapIntensity();
    MapColor();
    if (info_.rows == 0) return;
    row_ = AddColumn("rowIndex");
    column_ = AddColumn("columnIndex");
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    const std::uint64_t end =
        std::min<std::uint64_t>(scan_.points.record_count, done_ + kChunkRecords);
    if (done_ == end) return false;
    while (done_ < end) {
      const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(kBatchRecords, end - done_));
      for (Column& column : columns_) column.stream.Read(std::span(column.values).first(n));
      for (std::size_t i = 0; i < n; ++i) Add(i, chunk);
      done_ += n;
    }
    if (done_ == scan_.points.record_count) collector_.Finish();
    return true;
  }

 private:
  /// A field that is read, or nothing.
  using ColumnIndex = std::optional<std::size_t>;

  void FillInfo(int scan_index) {
    info_.path = file_.path();
    info_.format = "E57";
    info_.scan_index = scan_index;
    info_.scan_count = scan_.scan_count;
    info_.point_count = scan_.points.record_count;
    info_.guid = scan_.guid;
    info_.name = scan_.name;
    info_.crs = scan_.crs;
    info_.rows = scan_.rows;
    info_.columns = scan_.columns;
    info_.world_from_scan = scan_.world_from_scan;
    info_.notes = scan_.notes;
    if (file_.surplus() > 0) {
      info_.notes.push_back(fmt::format("{} bytes behind the end stated by the file header ignored",
                                        file_.surplus()));
    }
  }

  const E57Field* Find(std::string_view name) const {
    for (const E57Field& field : scan_.fields) {
      if (field.name == name && field.type != E57Type::kString) return &field;
    }
    return nullptr;
  }

  bool HasAll(const std::array<std::string_view, 3>& names) const {
    return std::all_of(names.begin(), names.end(),
                       [this](std::string_view name) { return Find(name) != nullptr; });
  }

  ColumnIndex AddColumn(std::string_view name) {
    const E57Field* field = Find(name);
    if (field == nullptr) return std::nullopt;
    const auto stream = static_cast<std::size_t>(field - scan_.fields.data());
    columns_.push_back({FieldStream(section_, *field, stream), std::vector<double>(kBatchRecords)});
    return columns_.size() - 1;
  }

  void MapCoordinates() {
    std::array<std::string_view, 3> names{"cartesianX", "cartesianY", "cartesianZ"};
    std::string_view state = "cartesianInvalidState";
    if (!HasAll(names)) {
      is_spherical_ = true;
      names = {"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
      state = "sphericalInvalidState";
    }
    if (!HasAll(names)) {
      throw file_.Error(scan_.points.stated_at, "a point record that lacks a coordinate",
                        "cartesianX, Y and Z, or sphericalRange, Azimuth and Elevation");
    }
    for (std::size_t i = 0; i < 3; ++i) coordinates_[i] = AddColumn(names[i]).value_or(0);
    invalid_ = AddColumn(state);
  }

  void MapIntensity() {
    intensity_ = AddColumn("intensity");
    info_.has_intensity = intensity_.has_value();
    E57Limits limits{0.0, 1.0};
    if (intensity_) {
      limits = LimitsOf(scan_.intensity_limits, columns_[*intensity_].stream.field());
      intensity_invalid_ = AddColumn("isIntensityInvalid");
    }
    dark_ = limits.low;
    collector_.Configure(info_.rows > 0, {limits.low, limits.high});
  }

  void MapColor() {
    const std::array<std::string_view, 3> names{"colorRed", "colorGreen", "colorBlue"};
    info_.has_rgb = HasAll(names);
    if (!info_.has_rgb) return;
    for (std::size_t i = 0; i < 3; ++i) {
      color_[i] = AddColumn(names[i]).value_or(0);
      color_limits_[i] = LimitsOf(scan_.color_limits[i], columns_[color_[i]].stream.field());
    }
    info_.rgb_16_bit =
        std::any_of(color_limits_.begin(), color_limits_.end(),
                    [](const E57Limits& limits) { return limits.high - limits.low != 255.0; });
    color_invalid_ = AddColumn("isColorInvalid");
  }

  double Value(std::size_t column, std::size_t i) const { return columns_[column].values[i]; }
  bool IsMarked(const ColumnIndex& column, std::size_t i) const {
    return column && Value(*column, i) != 0.0;
  }

  void Add(std::size_t i, PointChunk& chunk) {
    // State 1 says that only the direction holds, 2 that nothing does.
    if (IsMarked(invalid_, i)) {
      collector_.DropInvalid();
      return;
    }
    const double a = Value(coordinates_[0], i);
    const double b = Value(coordinates_[1], i);
    const double c = Value(coordinates_[2], i);
    const bool added =
        is_spherical_ ? collector_.AddPoint(a * std::cos(c) * std::cos(b),
                                            a * std::cos(c) * std::sin(b), a * std::sin(c), chunk)
                      : collector_.AddPoint(a, b, c, chunk);
    if (!added) return;
    if (intensity_) {
      collector_.AddIntensity(IsMarked(intensity_invalid_, i) ? dark_ : Value(*intensity_, i),
                              chunk);
    }
    if (info_.has_rgb) AddColor(i, chunk);
    if (row_ && column_) {
      collector_.AddCell(Value(*row_, i) - static_cast<double>(scan_.first_row),
                         Value(*column_, i) - static_cast<double>(scan_.first_column), info_,
                         chunk);
    }
  }

  void AddColor(std::size_t i, PointChunk& chunk) const {
    std::array<std::uint16_t, 3> rgb{};
    for (std::size_t k = 0; k < 3 && !IsMarked(color_invalid_, i); ++k) {
      rgb[k] = ColorOf(Value(color_[k], i), color_limits_[k]);
    }
    chunk.rgb.push_back(rgb);
  }

  PagedFile file_;
  E57Scan scan_;
  VectorSection section_;
  ScanInfo info_;
  PointCollector collector_;
  std::vector<Column> columns_;
  std::array<std::size_t, 3> coordinates_{};  // x y z, or range azimuth elevation
  bool is_spherical_ = false;
  ColumnIndex invalid_;
  ColumnIndex intensity_;
  ColumnIndex intensity_invalid_;
  double dark_ = 0.0;
  std::array<std::size_t, 3> color_{};
  std::array<E57Limits, 3> color_limits_;
  ColumnIndex color_invalid_;
  ColumnIndex row_;
  ColumnIndex column_;
  std::uint64_t done_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> OpenE57(const std::string& path, int scan_index) {
  return std::make_unique<E57Reader>(path, scan_index);
}

}  // namespace backsight
