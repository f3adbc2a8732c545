#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/cloud_writer.h"
#include "io/endian_bytes.h"
#include "io/las_header.h"

namespace backsight {
namespace {

constexpr double kMaxSteps = std::numeric_limits<std::int32_t>::max();

// Byte offsets in a record of point format 6, and of the colour that format 7 adds.
constexpr std::size_t kIntensity = 12;
constexpr std::size_t kReturns = 14;
constexpr std::size_t kPointSourceId = 20;
constexpr std::size_t kColor = 30;

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

class LasWriter : public CloudWriter {
 public:
  explicit LasWriter(const CloudWriterSpec& spec) : spec_(spec), file_(spec.path) {
    if (!(spec.scale_m > 0.0) || !std::isfinite(spec.scale_m)) {
      throw InputError({spec.path, fmt::format("a LAS step of {} m", spec.scale_m),
                        "a positive number", "correct the step"});
    }
    header_.point_format = spec.has_rgb ? 7 : 6;
    header_.generator = spec.generator;
    header_.scale.setConstant(spec.scale_m);
    for (int axis = 0; axis < 3; ++axis) header_.offset[axis] = ChooseOffset(spec, axis);
    low_.fill(std::numeric_limits<std::int32_t>::max());
    high_.fill(std::numeric_limits<std::int32_t>::min());
    WriteHeader();
  }

  void Write(const PointChunk& chunk, int station_number) override {
    if (station_number < 1 || station_number > 65535) {
      throw InputError({spec_.path, fmt::format("station number {}", station_number),
                        "1 to 65535, what a LAS Point Source ID can hold",
                        "merge fewer stations into one file"});
    }
    std::array<char, 36> record{};  // GPS time, class, flags and scan angle stay 0
    record[kReturns] = 0x11;        // return 1 of 1
    StoreBytes(record.data() + kPointSourceId, static_cast<std::uint16_t>(station_number));
    const std::string_view bytes(record.data(), LasRecordBytes(header_.point_format));
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      StoreCoordinates({chunk.x[i], chunk.y[i], chunk.z[i]}, record.data());
      if (spec_.has_intensity && !chunk.intensity.empty()) {
        const float value = std::clamp(chunk.intensity[i], 0.0F, 1.0F);
        StoreBytes(record.data() + kIntensity,
                   static_cast<std::uint16_t>(std::lround(value * 65535.0F)));
      }
      for (std::size_t c = 0; c < 3 && spec_.has_rgb && !chunk.rgb.empty(); ++c) {
        StoreBytes(record.data() + kColor + 2 * c, chunk.rgb[i][c]);
      }
      file_.Write(bytes);
      ++header_.points;
    }
  }

  std::uint64_t Finish() override {
    WriteHeader();
    file_.Sync();
    const LasHeader written = VerifyLas(file_.temporary_path());
    BACKSIGHT_CHECK(written.points == header_.points, "the LAS file lost points");
    file_.Commit();
    return header_.points;
  }

 private:
  void StoreCoordinates(const Eigen::Vector3d& point, char* record) {
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = std::round((point[axis] - header_.offset[axis]) / spec_.scale_m);
      if (!(std::abs(steps) <= kMaxSteps)) {
        throw InputError(
            {spec_.path, fmt::format("a point at {} in axis {}", point[axis], axis),
             fmt::format("within {} m of {}", kMaxSteps * spec_.scale_m, header_.offset[axis]),
             "choose a coarser LAS step"});
      }
      const auto step = static_cast<std::int32_t>(steps);
      const auto a = static_cast<std::size_t>(axis);
      low_[a] = std::min(low_[a], step);
      high_[a] = std::max(high_[a], step);
      StoreBytes(record + 4 * a, step);
    }
  }

  /// Written first with zeros to hold the place, at the end with the counts and bounds that came
  /// about; the bounds are those of the rounded coordinates, as a reader computes them.
  void WriteHeader() {
    if (header_.points == 0) {
      header_.min = header_.max = Eigen::Vector3d::Zero();
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        header_.min[axis] = header_.offset[axis] + header_.scale[axis] * low_[a];
        header_.max[axis] = header_.offset[axis] + header_.scale[axis] * high_[a];
      }
    }
    const auto bytes = EncodeLasHeader(header_);
    const std::string_view view(bytes.data(), bytes.size());
    if (has_header_) {
      file_.Overwrite(0, view);
    } else {
      file_.Write(view);
    }
    has_header_ = true;
  }

  CloudWriterSpec spec_;
  AtomicFile file_;
  LasHeader header_;
  std::array<std::int32_t, 3> low_{};
  std::array<std::int32_t, 3> high_{};
  bool has_header_ = false;
};

}  // namespace

std::unique_ptr<CloudWriter> CreateLasWriter(const CloudWriterSpec& spec) {
  return std::make_unique<LasWriter>(spec);
}

}  // namespace backsight
