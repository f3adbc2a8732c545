#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace backsight {

inline constexpr std::size_t kLasHeaderBytes = 375;

/// The parts of a LAS 1.4 header (ASPRS LAS 1.4 R15, section 2.4) that Backsight's files differ in.
/// The rest is fixed: point data right behind the header, no VLR or EVLR, WKT bit set (mandatory
/// for point formats 6 and up; without a WKT record the coordinate system is unknown), creation
/// day and year 0 so that equal runs give equal bytes, all points return 1 of 1.
struct LasHeader {
  int point_format = 6;   ///< 6, or 7 with colour
  std::string generator;  ///< generating software; at most 32 bytes are kept
  std::uint64_t points = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();   ///< metres per step
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector3d min = Eigen::Vector3d::Zero();     ///< metres
  Eigen::Vector3d max = Eigen::Vector3d::Zero();     ///< metres
};

/// Bytes of a point record of format 6 (30) or 7 (36).
std::size_t LasRecordBytes(int point_format);

std::array<char, kLasHeaderBytes> EncodeLasHeader(const LasHeader& header);

/// Throws InputError naming `path` unless `bytes` are such a header.
LasHeader DecodeLasHeader(std::string_view bytes, const std::string& path);

/// Reads a LAS file written by Backsight from end to end and throws InputError unless the header's
/// point count fits the file's size and its bounding box is exactly that of the points. Returns the
/// header. Cost: one pass over the file.
LasHeader VerifyLas(const std::string& path);

}  // namespace backsight
