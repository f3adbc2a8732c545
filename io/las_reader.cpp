#include "io/las_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "io/block_reader.h"
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

/// Extremes of the integers that coordinates are stored as.
struct StepBounds {
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;

  StepBounds() {
    low.fill(std::numeric_limits<std::int32_t>::max());
    high.fill(std::numeric_limits<std::int32_t>::min());
  }
  void Add(const StepBounds& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }
};

/// Records, and what was found in them.
struct LasBlock : ScanBlock {
  std::vector<char> bytes;
  std::uint64_t records = 0;
  bool is_last = false;  ///< nothing of the scan follows
  PointCollector counts;
  StepBounds bounds;
  std::uint64_t synthetic = 0;
  std::uint64_t clamped_colors = 0;
};

class LasReader : public BlockReader<LasBlock> {
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
  }

  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return collector_.tally(); }

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

  bool Take(LasBlock& block) override {
    if (taken_ == header_.points) return false;
    const std::uint64_t most =
        std::clamp<std::uint64_t>(kBlockBytes / header_.point_bytes, 1, kChunkRecords);
    block.records = std::min<std::uint64_t>(most, header_.points - taken_);
    block.bytes.resize(static_cast<std::size_t>(block.records) * header_.point_bytes);
    const std::uint64_t start = source_.position();
    const std::size_t got = source_.ReadSome(block.bytes.data(), block.bytes.size());
    if (got < block.bytes.size()) {
      const std::uint64_t whole = got / header_.point_bytes;
      throw source_.Truncated(start + whole * header_.point_bytes, "points", header_.points,
                              taken_ + whole);
    }
    taken_ += block.records;
    block.is_last = taken_ == header_.points;
    return true;
  }

  void Decode(LasBlock& block) const override {
    block.points.Clear();
    block.counts = collector_.ForPart();
    block.bounds = StepBounds();
    block.synthetic = block.clamped_colors = 0;
    for (std::size_t i = 0; i < block.records; ++i) {
      AddRecord(block.bytes.data() + i * header_.point_bytes, block);
    }
  }

  void Count(LasBlock& block) override {
    collector_.Add(block.counts);
    bounds_.Add(block.bounds);
    synthetic_ += block.synthetic;
    clamped_colors_ += block.clamped_colors;
    if (block.is_last) Finish();
  }

  void AddRecord(const char* record, LasBlock& block) const {
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto step = LoadBytes<std::int32_t>(record + 4 * a);
      block.bounds.low[a] = std::min(block.bounds.low[a], step);
      block.bounds.high[a] = std::max(block.bounds.high[a], step);
      point[axis] = header_.Metres(axis, step);
    }
    const LasClass kind = ClassOf(record, header_);
    if (kind.withheld) {
      block.counts.SkipWithheld();
      return;
    }
    if (kind.synthetic) ++block.synthetic;
    PointChunk& chunk = block.points;
    if (!block.counts.AddPoint(point.x(), point.y(), point.z(), chunk)) return;
    chunk.classification.push_back(kind.number);
    if (info_.has_intensity) {
      block.counts.AddIntensity(LoadBytes<std::uint16_t>(record + LasAt::kPointIntensity), chunk);
    }
    if (info_.has_rgb) AddColor(record + layout_.rgb, block);
    if (info_.has_gps_time) {
      const auto time = LoadBytes<double>(record + layout_.gps_time);
      chunk.gps_time.push_back(time + (header_.time_offset * kMillion - kAdjustedTime));
    }
  }

  void AddColor(const char* bytes, LasBlock& block) const {
    std::array<std::uint16_t, 3> rgb{};
    bool too_bright = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto value = LoadBytes<std::uint16_t>(bytes + 2 * c);
      too_bright = too_bright || (color_scale_ == ColorScale::k8Bit && value > 255);
      rgb[c] = ScaleColor(value, color_scale_);
    }
    if (too_bright) ++block.clamped_colors;
    block.points.rgb.push_back(rgb);
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
      const double min = header_.Metres(axis, bounds_.low[a]);
      const double max = header_.Metres(axis, bounds_.high[a]);
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
  StepBounds bounds_;
  std::uint64_t taken_ = 0;
  std::uint64_t synthetic_ = 0;
  std::uint64_t clamped_colors_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> OpenLas(const std::string& path) {
  return std::make_unique<LasReader>(path);
}

}  // namespace backsight
