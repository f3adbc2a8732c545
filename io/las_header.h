#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/byte_source.h"
#include "io/las_format.h"

namespace backsight {

/// The public header block of a LAS file (ASPRS LAS 1.4 R15, section 2.4; 1.0 to 1.5 are read, 1.4
/// is written) and what its records state of the reference system.
struct LasHeader {
  int version_minor = 4;
  unsigned global_encoding = LasEncoding::kWkt;
  std::string generator;  ///< generating software; at most 32 bytes are kept
  std::size_t header_bytes = kLasHeaderBytes;
  std::uint64_t point_offset = kLasHeaderBytes;  ///< byte of the first point
  std::uint32_t record_count = 0;                ///< variable length records behind the header
  int point_format = 6;                          ///< 0 to 10
  std::size_t point_bytes = 30;                  ///< bytes from point to point
  std::uint64_t points = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();   ///< metres per step
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector3d min = Eigen::Vector3d::Zero();     ///< metres
  Eigen::Vector3d max = Eigen::Vector3d::Zero();     ///< metres
  std::uint64_t extended_offset = 0;  ///< byte of the first extended variable length record
  std::uint32_t extended_count = 0;
  int time_offset = 1000;  ///< GPS times are seconds of GPS time minus this many million
  std::string crs;         ///< WKT, or "GeoTIFF: ..."; empty: none stated

  /// Metres of a coordinate of `step` in `axis`.
  double Metres(int axis, std::int32_t step) const { return step * scale[axis] + offset[axis]; }
};

/// Reads the header at the beginning of `source`, which may be of any version from 1.0 to 1.5, and
/// the records that hold the reference system. Repairs are added to `notes`: point counts that
/// disagree, records that cannot be where they are said to be, bytes that nothing accounts for.
/// Throws InputError with the byte for what no reading can make sense of: another version, a header
/// or point record shorter than the standard's, a scale that is not a positive number, points
/// beyond the end of the file.
LasHeader ReadLasHeader(ByteSource& source, std::vector<std::string>& notes);

/// The bytes of a LAS 1.4 header. What LasHeader does not tell is fixed: creation day and year 0,
/// so that equal runs give equal bytes; all points return 1 of 1; legacy counts 0, as the standard
/// demands for point formats 6 and up.
std::array<char, kLasHeaderBytes> EncodeLasHeader(const LasHeader& header);

}  // namespace backsight
