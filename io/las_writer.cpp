#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/endian_bytes.h"
#include "io/las_check.h"
#include "io/las_crs.h"
#include "io/las_header.h"

namespace backsight {
namespace {

constexpr double kMaxSteps = std::numeric_limits<std::int32_t>::max();

// Byte offsets in a record of point format 6, and of the colour that format 7 adds.
constexpr std::size_t kReturns = 14;
constexpr std::size_t kClass = 16;
constexpr std::size_t kPointSourceId = 20;
constexpr std::size_t kGpsTime = 22;
constexpr std::size_t kColor = 30;
constexpr std::size_t kMaxPointBytes = 36;

/// The offset in the middle of the bounds, rounded to whole metres where the bounds still fit.
double ChooseOffset(const CloudWriterSpec& spec, int axis) {
  const double min = spec.min[axis];
  const double max = spec.max[axis];
  if (!std::isfinite(min) || !std::isfinite(max) || min > max) {
    throw InputError({spec.path, fmt::format("bounds {} to {} in axis {}", min, max, axis),
                      "finite bounds, smaller one first", ""});
  }
  const double middle = min + (max - min) / 2.0;
  for (const double offset : {std::round(middle), middle}) {
    // A step is left free at each end for the rounding of coordinates.
    if (std::max(max - offset, offset - min) <= (kMaxSteps - 1.0) * spec.scale_m) return offset;
  }
  throw InputError(
      {spec.path,
       fmt::format("an extent of {} m in axis {} with steps of {} m", max - min, axis,
                   spec.scale_m),
       fmt::format("<= {} m, what LAS can count in such steps", 2.0 * kMaxSteps * spec.scale_m),
       "choose a coarser LAS step or split the cloud"});
}

/// The header of every file of the cloud, or an error before anything is written.
LasHeader PlanHeader(const CloudWriterSpec& spec) {
  if (!(spec.scale_m > 0.0) || !std::isfinite(spec.scale_m)) {
    throw InputError({spec.path, fmt::format("a LAS step of {} m", spec.scale_m),
                      "a positive number", "correct the step"});
  }
  if (spec.wkt.size() > 65534 || CleanCrsText(spec.wkt) != spec.wkt) {
    throw InputError({spec.path, fmt::format("a WKT of {} bytes", spec.wkt.size()),
                      "UTF-8 text of at most 65534 bytes, what a LAS record can hold",
                      "state the reference system more briefly"});
  }
  LasHeader header;
  header.point_format = spec.has_rgb ? 7 : 6;
  header.point_bytes = LasPointLayoutOf(header.point_format).bytes;
  header.generator = spec.generator;
  header.crs = spec.wkt;
  if (!spec.wkt.empty()) {
    header.record_count = 1;
    header.point_offset += kLasRecordHeaderBytes + spec.wkt.size() + 1;
  }
  header.scale.setConstant(spec.scale_m);
  for (int axis = 0; axis < 3; ++axis) header.offset[axis] = ChooseOffset(spec, axis);
  return header;
}

/// One file of the cloud.
class LasFile {
 public:
  LasFile(const std::string& path, const LasHeader& plan) : file_(path), header_(plan) {
    low_.fill(std::numeric_limits<std::int32_t>::max());
    high_.fill(std::numeric_limits<std::int32_t>::min());
    const auto place = EncodeLasHeader(header_);  // to be replaced in Close()
    file_.Write({place.data(), place.size()});
    if (!header_.crs.empty()) file_.Write(EncodeWktRecord(header_.crs));
  }

  std::uint64_t points() const { return header_.points; }

  void Add(const std::array<std::int32_t, 3>& steps, std::string_view record) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low_[axis] = std::min(low_[axis], steps[axis]);
      high_[axis] = std::max(high_[axis], steps[axis]);
    }
    file_.Write(record);
    ++header_.points;
  }

  /// Writes the counts and bounds that came about, those of the rounded coordinates as a reader
  /// computes them, and compares what the disk then holds.
  void Close(bool has_gps_time, const std::function<void()>& between) {
    if (has_gps_time) header_.global_encoding |= LasEncoding::kAdjustedTime;
    for (int axis = 0; axis < 3 && header_.points > 0; ++axis) {
      header_.min[axis] = header_.Metres(axis, low_[static_cast<std::size_t>(axis)]);
      header_.max[axis] = header_.Metres(axis, high_[static_cast<std::size_t>(axis)]);
    }
    const auto bytes = EncodeLasHeader(header_);
    file_.Overwrite(0, {bytes.data(), bytes.size()});
    file_.Seal();
    Compare(VerifyLas(file_.temporary_path(), between));
  }

  void Commit(const std::string& path) {
    file_.Retarget(path);
    file_.Commit();
  }

 private:
  void Compare(const LasHeader& read) const {
    const auto require = [&](bool same, std::string_view what) {
      if (same) return;
      throw InputError({file_.path(), fmt::format("{} other than written", what),
                        "what was written, when it is read again",
                        "write the file again; check the disk if this repeats"});
    };
    require(read.points == header_.points, fmt::format("{} points,", read.points));
    require(read.crs == header_.crs, "a reference system");
    require(read.point_format == header_.point_format, "a point format");
    require(read.global_encoding == header_.global_encoding, "an encoding");
    require(read.scale == header_.scale && read.offset == header_.offset, "a scale or offset");
    require(read.min == header_.min && read.max == header_.max, "bounds");
  }

  AtomicFile file_;
  LasHeader header_;
  std::array<std::int32_t, 3> low_{};
  std::array<std::int32_t, 3> high_{};
};

class LasWriter : public CloudWriter {
 public:
  explicit LasWriter(const CloudWriterSpec& spec) : spec_(spec), plan_(PlanHeader(spec)) {
    files_.push_back(std::make_unique<LasFile>(spec_.path, plan_));
  }

  void Write(const PointChunk& chunk, int station_number) override {
    if (station_number < 1 || station_number > 65535) {
      throw InputError({spec_.path, fmt::format("station number {}", station_number),
                        "1 to 65535, what a LAS Point Source ID can hold",
                        "merge fewer stations into one file"});
    }
    has_gps_time_ = has_gps_time_ || !chunk.gps_time.empty();
    std::array<char, kMaxPointBytes> record{};  // flags and scan angle stay 0
    record[kReturns] = 0x11;                    // return 1 of 1
    StoreBytes(record.data() + kPointSourceId, static_cast<std::uint16_t>(station_number));
    const std::string_view bytes(record.data(), plan_.point_bytes);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const auto steps = StepsOf({chunk.x[i], chunk.y[i], chunk.z[i]});
      for (std::size_t axis = 0; axis < 3; ++axis) {
        StoreBytes(record.data() + 4 * axis, steps[axis]);
      }
      StoreAttributes(chunk, i, record.data());
      FileWithRoom().Add(steps, bytes);
    }
  }

  std::uint64_t Finish() override {
    files_.back()->Close(has_gps_time_, spec_.between);
    std::uint64_t points = 0;
    for (const auto& file : files_) points += file->points();
    const std::vector<WrittenFile> names = WrittenFiles(spec_, points);
    BACKSIGHT_CHECK(names.size() == files_.size(), "the number of files is not the planned one");
    for (std::size_t i = 0; i < files_.size(); ++i) files_[i]->Commit(names[i].path);
    return points;
  }

 private:
  std::array<std::int32_t, 3> StepsOf(const Eigen::Vector3d& point) const {
    std::array<std::int32_t, 3> result{};
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = std::round((point[axis] - plan_.offset[axis]) / spec_.scale_m);
      if (!(std::abs(steps) <= kMaxSteps)) {
        throw InputError(
            {spec_.path, fmt::format("a point at {} in axis {}", point[axis], axis),
             fmt::format("within {} m of {}", kMaxSteps * spec_.scale_m, plan_.offset[axis]),
             "choose a coarser LAS step"});
      }
      result[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(steps);
    }
    return result;
  }

  void StoreAttributes(const PointChunk& chunk, std::size_t i, char* record) const {
    if (spec_.has_intensity && !chunk.intensity.empty()) {
      const float value = std::clamp(chunk.intensity[i], 0.0F, 1.0F);
      StoreBytes(record + LasAt::kPointIntensity,
                 static_cast<std::uint16_t>(std::lround(value * 65535.0F)));
    }
    if (!chunk.classification.empty()) StoreBytes(record + kClass, chunk.classification[i]);
    if (!chunk.gps_time.empty()) StoreBytes(record + kGpsTime, chunk.gps_time[i]);
    for (std::size_t c = 0; c < 3 && spec_.has_rgb && !chunk.rgb.empty(); ++c) {
      StoreBytes(record + kColor + 2 * c, chunk.rgb[i][c]);
    }
  }

  LasFile& FileWithRoom() {
    if (spec_.max_points_per_file > 0 && files_.back()->points() == spec_.max_points_per_file) {
      files_.back()->Close(has_gps_time_, spec_.between);
      files_.push_back(std::make_unique<LasFile>(spec_.path, plan_));
    }
    return *files_.back();
  }

  CloudWriterSpec spec_;
  LasHeader plan_;
  std::vector<std::unique_ptr<LasFile>> files_;  // all but the last are closed
  bool has_gps_time_ = false;
};

}  // namespace

std::unique_ptr<CloudWriter> CreateLasWriter(const CloudWriterSpec& spec) {
  return std::make_unique<LasWriter>(spec);
}

}  // namespace backsight
