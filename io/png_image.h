#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace backsight {

/// An 8-bit RGB picture, rows from the top.
struct RgbImage {
  RgbImage() = default;
  /// Filled with one colour. `width` and `height` in pixels, both at least 1.
  RgbImage(int width, int height, std::array<std::uint8_t, 3> fill);

  std::array<std::uint8_t, 3> At(int x, int y) const;
  void Set(int x, int y, std::array<std::uint8_t, 3> colour);

  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height
};

/// The bytes of a PNG file, with a palette where 256 colours suffice. Throws InternalError if the
/// sizes do not fit together.
std::vector<std::uint8_t> EncodePng(const RgbImage& image);

}  // namespace backsight
