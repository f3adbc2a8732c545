#include "tests/io/las_bytes.h"

#include <algorithm>

#include "tests/io/append_bytes.h"

namespace backsight {
namespace {

/// Overwrites bytes of a block that is there already.
template <Arithmetic T>
void Put(std::string& block, std::size_t at, T value) {
  std::string bytes;
  Append(bytes, value);
  block.replace(at, bytes.size(), bytes);
}

std::string PointRecord(const LasTestFile& file, const LasTestPoint& point) {
  std::string record;
  for (const std::int32_t step : point.steps) Append(record, step);
  Append(record, point.intensity);
  if (file.format < 6) {
    record += '\x09';  // return 1 of 1
    record += static_cast<char>(point.classification | (point.synthetic ? 32U : 0U) |
                                (point.withheld ? 128U : 0U));
    record += std::string(2, '\x55');  // scan angle, user data
  } else {
    record += '\x11';
    record += static_cast<char>((point.synthetic ? 1U : 0U) | (point.withheld ? 4U : 0U) | 0x40U);
    record += static_cast<char>(point.classification);
    record += std::string(3, '\x55');  // user data, scan angle
  }
  Append(record, std::uint16_t{513});  // point source
  if (file.HasGpsTime()) Append(record, point.gps_time);
  for (const std::uint16_t channel : point.rgb) {
    if (file.HasRgb()) Append(record, channel);
  }
  // Near infrared, wave packets and extra bytes.
  record.resize(file.PointBytes(), '\x7e');
  return record;
}

}  // namespace

std::size_t LasTestFile::PointBytes() const {
  constexpr std::array<std::size_t, 11> kBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  return kBytes[static_cast<std::size_t>(format)] + extra_point_bytes;
}

std::size_t LasTestFile::HeaderBytes() const {
  constexpr std::array<std::size_t, 6> kBytes{227, 227, 227, 235, 375, 393};
  return kBytes[static_cast<std::size_t>(minor)] + extra_header_bytes;
}

std::string LasTestFile::Bytes() const {
  std::string all_records;
  for (const std::string& record : records) all_records += record;
  std::string bytes(HeaderBytes(), '\0');
  const std::size_t point_offset = bytes.size() + all_records.size();
  bytes.replace(0, 4, "LASF");
  Put(bytes, 6, static_cast<std::uint16_t>(encoding));
  bytes[24] = 1;
  bytes[25] = static_cast<char>(minor);
  Put(bytes, 94, static_cast<std::uint16_t>(HeaderBytes()));
  Put(bytes, 96, static_cast<std::uint32_t>(point_offset));
  Put(bytes, 100, static_cast<std::uint32_t>(records.size()));
  bytes[104] = static_cast<char>(format);
  Put(bytes, 105, static_cast<std::uint16_t>(PointBytes()));
  if (format < 6 || minor < 4) Put(bytes, 107, static_cast<std::uint32_t>(points.size()));
  for (std::size_t a = 0; a < 3; ++a) {
    Put(bytes, 131 + 8 * a, scale[a]);
    Put(bytes, 155 + 8 * a, offset[a]);
    std::vector<double> values;
    for (std::size_t i = 0; i < points.size(); ++i) values.push_back(Coordinate(i, a));
    if (values.empty()) continue;
    Put(bytes, 179 + 16 * a, *std::max_element(values.begin(), values.end()));
    Put(bytes, 187 + 16 * a, *std::min_element(values.begin(), values.end()));
  }
  if (minor >= 4) {
    if (!extended.empty()) {
      Put(bytes, 235, static_cast<std::uint64_t>(point_offset + points.size() * PointBytes()));
      Put(bytes, 243, static_cast<std::uint32_t>(extended.size()));
    }
    Put(bytes, 247, static_cast<std::uint64_t>(points.size()));
  }
  if (minor >= 5) Put(bytes, 391, time_offset);
  bytes += all_records;
  for (const LasTestPoint& point : points) bytes += PointRecord(*this, point);
  for (const std::string& record : extended) bytes += record;
  return bytes;
}

std::string LasTestRecord(const std::string& user, std::uint16_t id, const std::string& contents,
                          bool extended) {
  std::string record(2, '\0');
  record += user + std::string(16 - user.size(), '\0');
  Append(record, id);
  if (extended) {
    Append(record, static_cast<std::uint64_t>(contents.size()));
  } else {
    Append(record, static_cast<std::uint16_t>(contents.size()));
  }
  return record + std::string(32, 'd') + contents;
}

std::string GeoKeyBytes(const std::vector<std::array<std::uint16_t, 4>>& entries) {
  std::string bytes;
  for (const std::uint16_t head : {std::uint16_t{1}, std::uint16_t{1}, std::uint16_t{0}}) {
    Append(bytes, head);
  }
  Append(bytes, static_cast<std::uint16_t>(entries.size()));
  for (const auto& entry : entries) {
    for (const std::uint16_t part : entry) Append(bytes, part);
  }
  return bytes;
}

std::vector<LasTestPoint> RandomLasPoints(int format, std::size_t n, Random& random) {
  std::vector<LasTestPoint> points(n);
  for (LasTestPoint& point : points) {
    for (std::int32_t& step : point.steps) {
      step = static_cast<std::int32_t>(static_cast<std::int64_t>(random.Index(4294967296U)) -
                                       2147483648);
    }
    point.intensity = static_cast<std::uint16_t>(random.Index(65536));
    for (std::uint16_t& channel : point.rgb) {
      channel = static_cast<std::uint16_t>(random.Index(65536));
    }
    point.gps_time = random.Uniform(-1e8, 4e8);
    point.classification = static_cast<std::uint8_t>(random.Index(format < 6 ? 32 : 256));
    point.synthetic = random.Index(10) == 0;
    point.withheld = random.Index(10) == 0;
  }
  return points;
}

}  // namespace backsight
