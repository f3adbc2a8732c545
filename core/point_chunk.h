#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace backsight {

/// A run of raw scan points as a structure of arrays, as readers hand them out and writers take
/// them. Coordinates are metres in the frame the producer states (readers: station frame).
/// The vectors behind `z` are either empty or as long as `x`.
struct PointChunk {
  std::vector<double> x, y, z;
  std::vector<float> intensity;                   ///< 0 (dark) to 1 (bright)
  std::vector<std::array<std::uint16_t, 3>> rgb;  ///< 0 to 65535 per channel
  std::vector<std::uint8_t> classification;       ///< ASPRS classes, LAS 1.4 R15 section 2.6
  /// Adjusted Standard GPS Time: seconds of satellite GPS time minus 1e9 (LAS 1.4 R15 section 2.4).
  std::vector<double> gps_time;
  std::vector<std::int32_t> row, column;  ///< cell of the scan grid, from 0

  std::size_t size() const { return x.size(); }
  bool empty() const { return x.empty(); }
  void Clear() {
    for (auto* values : {&x, &y, &z, &gps_time}) values->clear();
    intensity.clear();
    rgb.clear();
    classification.clear();
    for (auto* cells : {&row, &column}) cells->clear();
  }
};

}  // namespace backsight
