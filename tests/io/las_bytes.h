#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"

namespace backsight {

struct LasTestPoint {
  std::array<std::int32_t, 3> steps{};
  std::uint16_t intensity = 0;
  std::array<std::uint16_t, 3> rgb{};
  double gps_time = 0.0;
  std::uint8_t classification = 0;  ///< below 32 in formats 0 to 5
  bool synthetic = false;
  bool withheld = false;
};

/// A LAS file put together from the tables of the specification, without Backsight's own code.
struct LasTestFile {
  int minor = 4;
  int format = 6;
  unsigned encoding = 0;
  std::size_t extra_header_bytes = 0;
  std::size_t extra_point_bytes = 0;
  std::array<double, 3> scale{0.001, 0.001, 0.001};
  std::array<double, 3> offset{};
  std::vector<std::string> records;   ///< whole VLRs
  std::vector<std::string> extended;  ///< whole EVLRs, 1.4 and later
  std::uint16_t time_offset = 0;      ///< 1.5
  std::vector<LasTestPoint> points;

  bool HasRgb() const {
    for (const int with : {2, 3, 5, 7, 8, 10}) {
      if (format == with) return true;
    }
    return false;
  }
  bool HasGpsTime() const { return format != 0 && format != 2; }
  double Coordinate(std::size_t point, std::size_t axis) const {
    return points[point].steps[axis] * scale[axis] + offset[axis];
  }
  std::size_t PointBytes() const;
  std::size_t HeaderBytes() const;
  std::string Bytes() const;
};

/// A variable length record, or with `extended` an extended one.
std::string LasTestRecord(const std::string& user, std::uint16_t id, const std::string& contents,
                          bool extended = false);

/// The contents of a GeoTIFF key directory of {key, location, count, value} entries.
std::string GeoKeyBytes(const std::vector<std::array<std::uint16_t, 4>>& entries);

/// `n` points with all fields of the format at random.
std::vector<LasTestPoint> RandomLasPoints(int format, std::size_t n, Random& random);

}  // namespace backsight
