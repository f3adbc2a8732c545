#include "io/las_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "io/endian_bytes.h"
#include "io/las_crs.h"
#include "io/las_header.h"
#include "io/las_sample.h"
#include "io/point_collector.h"

namespace backsight {
namespace {

constexpr double kMillion = 1e6;
constexpr double kAdjustedTime = 1e9;

/// Flags and class of a record, which the formats keep in different places (section 2.6).
struct LasClass {
  std::uint8_t number = 0;
  bool synthetic = false;
  bool withheld = false;
};

LasClass ClassOf(const char* record, const LasHeader& header) {
  const auto byte = [record](std::size_t at) { return static_cast<unsigned char>(record[at]); };
  if (header.point_format >= 6) {
    return {byte(16), (byte(15) & 1U) != 0, (byte(15) & 4U) != 0};
  }
  if (header.version_minor == 0) return {byte(15), false, false};  // LAS 1.0 has no flags
  return {static_cast<std::uint8_t>(byte(15) & 31U), (byte(15) & 32U) != 0, (byte(15) & 128U) != 0};
}

class LasReader : public ScanReader {
 public:
  explicit LasReader(const std::string& path)
      : source_(path),
        header_(ReadLasHeader(source_, info_.notes)),
        layout_(LasPointLayoutOf(header_.point_format)) {
    info_.path = path;
    info_.format = fmt::format("LAS 1.{}", header_.version_minor);
    info_.point_count = header_.points;
    info_.crs = header_.crs;
    for (std::string& note : CrsUnitNotes(info_.crs)) info_.notes.push_back(std::move(note));
    UseSample(SampleLas(source_, header_));
    source_.Seek(header_.point_offset);
    low_.fill(std::numeric_limits<std::int32_t>::max());
    high_.fill(std::numeric_limits<std::int32_t>::min());
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (done_ == header_.points) return false;
    const std::uint64_t n = std::min<std::uint64_t>(kChunkRecords, header_.points - done_);
    for (std::uint64_t i = 0; i < n; ++i, ++done_) {
      const std::string_view bytes = source_.Peek(header_.point_bytes);
      if (bytes.size() < header_.point_bytes) {
        throw source_.Truncated(source_.position(), "points", header_.points, done_);
      }
      Add(bytes.data(), chunk);
      source_.Consume(header_.point_bytes);
    }
    if (done_ == header_.points) Finish();
    return true;
  }

 private:
  /// LAS does not say whether its optional fields are used, nor whether values of 8 bits were
  /// scaled to the 16 that it has for them.
  void UseSample(const LasSample& sample) {
    info_.has_classification = true;
    info_.has_intensity = sample.intensity > 0;
    info_.has_rgb = sample.color > 0;
    const bool adjusted = (header_.global_encoding & LasEncoding::kAdjustedTime) != 0;
    info_.has_gps_time = layout_.gps_time != 0 && adjusted;
    const auto note = [&](std::string what) {
      if (sample.points < header_.points) {
        what += fmt::format(", by a sample of {} points", sample.points);
      }
      info_.notes.push_back(std::move(what));
    };
    if (!info_.has_intensity && sample.points > 0) note("intensity is 0: taken as not recorded");
    if (layout_.rgb != 0 && !info_.has_rgb && sample.points > 0) {
      note("colours are 0: taken as not recorded");
    }
    if (sample.has_gps_time && !adjusted) note("GPS times lack their week: left out");
    IntensityRange range{0.0, 65535.0};
    if (info_.has_intensity && sample.intensity <= 255) {
      range.high = 255.0;
      note(fmt::format("intensity is <= {}: taken as 8 bit", sample.intensity));
    }
    if (info_.has_rgb && sample.color <= 255) {
      color_scale_ = ColorScale::k8Bit;
      note(fmt::format("colours are <= {}: taken as 8 bit", sample.color));
    }
    info_.rgb_16_bit = info_.has_rgb && color_scale_ != ColorScale::k8Bit;
    collector_.Configure(false, range);
  }

  void Add(const char* record, PointChunk& chunk) {
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto step = LoadBytes<std::int32_t>(record + 4 * a);
      low_[a] = std::min(low_[a], step);
      high_[a] = std::max(high_[a], step);
      point[axis] = header_.Metres(axis, step);
    }
    const LasClass kind = ClassOf(record, header_);
    if (kind.withheld) {
      collector_.SkipWithheld();
      return;
    }
    if (kind.synthetic) ++synthetic_;
    if (!collector_.AddPoint(point.x(), point.y(), point.z(), chunk)) return;
    chunk.classification.push_back(kind.number);
    if (info_.has_intensity) {
      collector_.AddIntensity(LoadBytes<std::uint16_t>(record + LasAt::kPointIntensity), chunk);
    }
    if (info_.has_rgb) AddColor(record + layout_.rgb, chunk);
    if (info_.has_gps_time) {
      const auto time = LoadBytes<double>(record + layout_.gps_time);
      chunk.gps_time.push_back(time + (header_.time_offset * kMillion - kAdjustedTime));
    }
  }

  void AddColor(const char* bytes, PointChunk& chunk) {
    std::array<std::uint16_t, 3> rgb{};
    bool too_bright = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto value = LoadBytes<std::uint16_t>(bytes + 2 * c);
      too_bright = too_bright || (color_scale_ == ColorScale::k8Bit && value > 255);
      rgb[c] = ScaleColor(value, color_scale_);
    }
    if (too_bright) ++clamped_colors_;
    chunk.rgb.push_back(rgb);
  }

  void Finish() {
    collector_.Finish();
    if (synthetic_ > 0) {
      collector_.AddNote(fmt::format("{} points flagged as synthetic are kept", synthetic_));
    }
    if (clamped_colors_ > 0) {
      collector_.AddNote(fmt::format("colour above 255 clamped in {} points", clamped_colors_));
    }
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double min = header_.Metres(axis, low_[a]);
      const double max = header_.Metres(axis, high_[a]);
      // Many programs write the bounds of the coordinates before rounding.
      const double most = 1.01 * header_.scale[axis];
      if (std::abs(min - header_.min[axis]) <= most && std::abs(max - header_.max[axis]) <= most) {
        continue;
      }
      collector_.AddNote(
          fmt::format("the header bounds axis {} by {} and {}, its points by {} and {}", axis,
                      header_.min[axis], header_.max[axis], min, max));
    }
  }

  ScanInfo info_;
  ByteSource source_;
  LasHeader header_;
  LasPointLayout layout_;
  PointCollector collector_;
  ColorScale color_scale_ = ColorScale::k16Bit;
  std::array<std::int32_t, 3> low_{};
  std::array<std::int32_t, 3> high_{};
  std::uint64_t done_ = 0;
  std::uint64_t synthetic_ = 0;
  std::uint64_t clamped_colors_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> OpenLas(const std::string& path) {
  return std::make_unique<LasReader>(path);
}

}  // namespace backsight
