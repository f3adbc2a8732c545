#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace backsight {

/// A run of raw scan points as a structure of arrays, as readers hand them out and writers take
/// them. Coordinates are metres in the frame the producer states (readers: station frame).
/// `intensity` and `rgb` are either empty or as long as `x`.
struct PointChunk {
  std::vector<double> x, y, z;
  std::vector<float> intensity;                   ///< 0 (dark) to 1 (bright)
  std::vector<std::array<std::uint16_t, 3>> rgb;  ///< 0 to 65535 per channel

  std::size_t size() const { return x.size(); }
  bool empty() const { return x.empty(); }
  void Clear() { x.clear(), y.clear(), z.clear(), intensity.clear(), rgb.clear(); }
};

}  // namespace backsight
