#pragma once

#include <cstddef>
#include <cstdint>

namespace backsight {

/// Byte offsets of the fields of the public header block (LAS 1.4 R15, section 2.4). Versions
/// before 1.4 end earlier but agree in what they have; 1.5 adds GPS times and their offset.
struct LasAt {
  static constexpr std::size_t kGlobalEncoding = 6;
  static constexpr std::size_t kVersion = 24;
  static constexpr std::size_t kSystemIdentifier = 26;
  static constexpr std::size_t kGenerator = 58;
  static constexpr std::size_t kHeaderBytes = 94;
  static constexpr std::size_t kPointOffset = 96;
  static constexpr std::size_t kRecordCount = 100;  ///< variable length records (VLR)
  static constexpr std::size_t kPointFormat = 104;
  static constexpr std::size_t kPointBytes = 105;
  static constexpr std::size_t kLegacyPoints = 107;
  static constexpr std::size_t kScale = 131;
  static constexpr std::size_t kOffset = 155;
  static constexpr std::size_t kBounds = 179;  ///< max x, min x, max y, min y, max z, min z
  static constexpr std::size_t kWaveforms = 227;
  static constexpr std::size_t kExtendedOffset = 235;  ///< extended VLR (EVLR)
  static constexpr std::size_t kExtendedCount = 243;
  static constexpr std::size_t kPoints = 247;
  static constexpr std::size_t kPointsByReturn = 255;
  static constexpr std::size_t kTimeOffset = 391;

  static constexpr std::size_t kPointIntensity = 12;  ///< in a point record
};

/// Header sizes of LAS 1.0 to 1.2, 1.4 and 1.5; files may have larger headers.
inline constexpr std::size_t kLas12HeaderBytes = 227;
inline constexpr std::size_t kLasHeaderBytes = 375;
inline constexpr std::size_t kLas15HeaderBytes = 393;

/// Bits of the global encoding.
struct LasEncoding {
  static constexpr unsigned kAdjustedTime = 1U << 0U;
  static constexpr unsigned kInternalWaveforms = 1U << 1U;
  static constexpr unsigned kWkt = 1U << 4U;
  static constexpr unsigned kTimeOffset = 1U << 6U;
};

/// Where the fields of a point record lie (section 2.6). Coordinates are the first 12 bytes and
/// intensity the next 2 in all formats; flags and classification differ between formats 0 to 5 and
/// 6 to 10.
struct LasPointLayout {
  std::size_t bytes = 0;     ///< of the standard's fields; records may be longer
  std::size_t gps_time = 0;  ///< byte offset; 0: none
  std::size_t rgb = 0;       ///< byte offset; 0: none
  bool has_waveform = false;
};

inline constexpr int kLasPointFormats = 11;

/// `format` from 0 to 10.
constexpr LasPointLayout LasPointLayoutOf(int format) {
  constexpr LasPointLayout kLayouts[kLasPointFormats] = {
      {20, 0, 0, false},   {28, 20, 0, false}, {26, 0, 20, false}, {34, 20, 28, false},
      {57, 20, 0, true},   {63, 20, 28, true}, {30, 22, 0, false}, {36, 22, 30, false},
      {38, 22, 30, false}, {59, 22, 0, true},  {67, 22, 30, true}};
  return kLayouts[format];
}

}  // namespace backsight
