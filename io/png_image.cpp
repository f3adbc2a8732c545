#include "io/png_image.h"

#include <png.h>

#include <algorithm>
#include <cstddef>

#include "core/error.h"

namespace backsight {

RgbImage::RgbImage(int width_px, int height_px, std::array<std::uint8_t, 3> fill)
    : width(width_px), height(height_px) {
  BACKSIGHT_CHECK(width > 0 && height > 0, "picture without pixels");
  rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = fill[i % 3];
}

std::array<std::uint8_t, 3> RgbImage::At(int x, int y) const {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

void RgbImage::Set(int x, int y, std::array<std::uint8_t, 3> colour) {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  std::copy(colour.begin(), colour.end(), rgb.begin() + static_cast<std::ptrdiff_t>(i));
}

std::vector<std::uint8_t> EncodePng(const RgbImage& image) {
  BACKSIGHT_CHECK(image.width > 0 && image.height > 0 &&
                      image.rgb.size() == 3 * static_cast<std::size_t>(image.width) *
                                              static_cast<std::size_t>(image.height),
                  "picture sizes");
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  const int written =
      png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr);
  BACKSIGHT_CHECK(written != 0, png.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace backsight
