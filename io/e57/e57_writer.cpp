#include "io/e57/e57_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/e57/e57_reader.h"
#include "io/e57/e57_xml_text.h"
#include "io/endian_bytes.h"

namespace backsight {
namespace {

constexpr std::array<const char*, 3> kAxes{"cartesianX", "cartesianY", "cartesianZ"};
// Doubles hold all integers up to here.
constexpr double kMaxSteps = 9007199254740992.0;

E57Field IntegerField(std::string name, std::int64_t maximum) {
  return {.name = std::move(name), .type = E57Type::kInteger, .minimum = 0, .maximum = maximum};
}

/// A field's own number, from 0 to `maximum`, for a value from 0 to 65535.
std::int64_t ColorStep(std::uint16_t value, bool is_16_bit) {
  return is_16_bit ? value : (value + 128) / 257;
}

}  // namespace

E57Writer::E57Writer(E57FileSpec spec) : spec_(std::move(spec)), out_(spec_.path) {
  out_.Reserve(kE57HeaderBytes);
}

void E57Writer::BeginScan(const E57ScanSpec& scan) {
  BACKSIGHT_CHECK(!points_, "the scan before is not ended");
  BACKSIGHT_CHECK((scan.rows > 0) == (scan.columns > 0), "a grid has rows and columns");
  scan_ = scan;
  fields_.clear();
  AddFields();
  points_.emplace(out_, fields_);
  written_.emplace_back().crs = spec_.crs;
}

void E57Writer::AddFields() {
  AddCoordinateFields();
  if (scan_.has_invalid_state) fields_.push_back(IntegerField("cartesianInvalidState", 2));
  if (scan_.rows > 0) {
    fields_.push_back(IntegerField("rowIndex", scan_.rows - 1));
    fields_.push_back(IntegerField("columnIndex", scan_.columns - 1));
  }
  if (scan_.has_intensity) {
    fields_.push_back({.name = "intensity", .type = E57Type::kSingle, .limits = {0.0, 1.0}});
  }
  for (const char* color : {"colorRed", "colorGreen", "colorBlue"}) {
    if (scan_.has_rgb) fields_.push_back(IntegerField(color, scan_.rgb_16_bit ? 65535 : 255));
  }
}

void E57Writer::AddCoordinateFields() {
  for (const int axis : {0, 1, 2}) {
    E57Field field;
    field.name = kAxes[static_cast<std::size_t>(axis)];
    if (scan_.coordinates != E57Coordinates::kScaledInteger) {
      const bool is_single = scan_.coordinates == E57Coordinates::kSingle;
      field.type = is_single ? E57Type::kSingle : E57Type::kDouble;
    } else {
      field.type = E57Type::kScaledInteger;
      field.scale = scan_.scale_m;
      const double low = std::floor(scan_.min[axis] / scan_.scale_m);
      const double high = std::ceil(scan_.max[axis] / scan_.scale_m);
      if (!(scan_.scale_m > 0.0 && low >= -kMaxSteps && low <= high && high <= kMaxSteps)) {
        throw InputError({spec_.path,
                          fmt::format("coordinates from {} to {} m in steps of {} m",
                                      scan_.min[axis], scan_.max[axis], scan_.scale_m),
                          "at most 2^53 steps from 0", "choose a coarser step"});
      }
      field.minimum = static_cast<std::int64_t>(low);
      field.maximum = static_cast<std::int64_t>(high);
    }
    fields_.push_back(std::move(field));
  }
}

std::int64_t E57Writer::Steps(double value_m, const E57Field& field) const {
  const double steps = std::round(value_m / field.scale);
  if (!(steps >= static_cast<double>(field.minimum) &&
        steps <= static_cast<double>(field.maximum))) {
    throw InputError({spec_.path, fmt::format("a point with {} {} m", field.name, value_m),
                      fmt::format("{} to {} m, the bounds of the scan", field.Value(field.minimum),
                                  field.Value(field.maximum)),
                      "state bounds that hold all points"});
  }
  return static_cast<std::int64_t>(steps);
}

void E57Writer::WriteCoordinates(const Eigen::Vector3d& point, bool is_point) {
  Eigen::Vector3d on_file = point;
  for (const int axis : {0, 1, 2}) {
    const auto i = static_cast<std::size_t>(axis);
    const E57Field& field = fields_[i];
    double& stored = on_file[axis];
    if (field.IsInteger()) {
      // What is no point need not lie within the bounds of those that are.
      const std::int64_t steps = is_point ? Steps(stored, field) : field.minimum;
      points_->Put(i, steps);
      stored = field.Value(steps);
    } else {
      if (field.type == E57Type::kSingle) stored = static_cast<double>(static_cast<float>(stored));
      if (is_point && !std::isfinite(stored)) {
        throw InputError({spec_.path, fmt::format("a point with {} {} m", field.name, point[axis]),
                          "a number that the chosen coordinates can hold",
                          "write double coordinates, or mark the record as invalid"});
      }
      points_->Put(i, is_point ? stored : 0.0);
    }
  }
  if (is_point) written_.back().AddPoint(on_file);
}

void E57Writer::WriteAttributes(const PointChunk& chunk, std::size_t i) {
  std::size_t field = scan_.has_invalid_state ? 4 : 3;
  if (scan_.rows > 0) {
    points_->Put(field++, std::int64_t{chunk.row[i]});
    points_->Put(field++, std::int64_t{chunk.column[i]});
  }
  if (scan_.has_intensity) {
    points_->Put(field++, static_cast<double>(std::clamp(chunk.intensity[i], 0.0F, 1.0F)));
  }
  for (std::size_t c = 0; c < 3 && scan_.has_rgb; ++c) {
    points_->Put(field++, ColorStep(chunk.rgb[i][c], scan_.rgb_16_bit));
  }
}

void E57Writer::Write(const PointChunk& chunk, std::span<const std::uint8_t> invalid_states) {
  BACKSIGHT_CHECK(points_, "no scan is begun");
  const std::size_t n = chunk.size();
  const auto fits = [n](bool wanted, std::size_t size) { return !wanted || size == n; };
  BACKSIGHT_CHECK(
      fits(scan_.has_intensity, chunk.intensity.size()) && fits(scan_.has_rgb, chunk.rgb.size()) &&
          fits(scan_.rows > 0, chunk.row.size()) && fits(scan_.rows > 0, chunk.column.size()) &&
          fits(scan_.has_invalid_state, invalid_states.size()),
      "an attribute of the scan is missing in a chunk");
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_point = !scan_.has_invalid_state || invalid_states[i] == 0;
    WriteCoordinates({chunk.x[i], chunk.y[i], chunk.z[i]}, is_point);
    if (scan_.has_invalid_state) points_->Put(3, std::int64_t{invalid_states[i]});
    WriteAttributes(chunk, i);
    points_->EndRecord();
  }
}

std::uint64_t E57Writer::EndScan() {
  BACKSIGHT_CHECK(points_, "no scan is begun");
  const std::uint64_t records = points_->Finish();
  CloudContent& written = written_.back();
  written.records = records;
  scans_xml_ +=
      E57ScanXml(scan_, fields_, {points_->file_offset(), records, written.low, written.high});
  points_.reset();
  return records;
}

void E57Writer::Finish() {
  BACKSIGHT_CHECK(!points_, "the last scan is not ended");
  out_.Align();
  const std::uint64_t xml_start = out_.position();
  const std::string xml = E57RootXml(spec_, scans_xml_);
  out_.Write(xml);
  std::array<char, kE57HeaderBytes> header{'A', 'S', 'T', 'M', '-', 'E', '5', '7'};
  StoreBytes(&header[8], std::uint32_t{1});
  StoreBytes(&header[16], out_.PhysicalBytes());
  StoreBytes(&header[24], E57Physical(xml_start));
  StoreBytes(&header[32], std::uint64_t{xml.size()});
  StoreBytes(&header[40], kE57PageBytes);
  out_.Fill(0, {header.data(), header.size()});
  out_.Seal();
  RequireReadable();
  out_.Commit();
}

void E57Writer::RequireReadable() const {
  for (std::size_t scan = 0; scan < written_.size(); ++scan) {
    const auto reader = OpenE57(out_.temporary_path(), static_cast<int>(scan));
    RequireWritten(spec_.path, *reader, written_[scan], spec_.between);
  }
}

}  // namespace backsight
