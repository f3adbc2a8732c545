#include "io/png_image.h"

#include <png.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>

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

namespace {

/// A picture of at most 256 colours as indices into them, in order of appearance.
struct IndexedImage {
  std::vector<std::uint8_t> colours;  // 3 each
  std::vector<std::uint8_t> pixels;
};

std::optional<IndexedImage> Index(const RgbImage& image) {
  constexpr std::size_t kMostColours = 256;
  IndexedImage indexed;
  indexed.pixels.reserve(image.rgb.size() / 3);
  std::map<std::uint32_t, std::uint8_t> indices;
  auto last = indices.end();  // pixels are mostly like the one before
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const std::uint32_t colour = static_cast<std::uint32_t>(image.rgb[i]) << 16U |
                                 static_cast<std::uint32_t>(image.rgb[i + 1]) << 8U |
                                 image.rgb[i + 2];
    if (last == indices.end() || last->first != colour) last = indices.find(colour);
    if (last == indices.end()) {
      if (indices.size() == kMostColours) return std::nullopt;
      last = indices.emplace(colour, static_cast<std::uint8_t>(indices.size())).first;
      indexed.colours.insert(indexed.colours.end(), &image.rgb[i], &image.rgb[i] + 3);
    }
    indexed.pixels.push_back(last->second);
  }
  return indexed;
}

}  // namespace

std::vector<std::uint8_t> EncodePng(const RgbImage& image) {
  BACKSIGHT_CHECK(image.width > 0 && image.height > 0 &&
                      image.rgb.size() == 3 * static_cast<std::size_t>(image.width) *
                                              static_cast<std::size_t>(image.height),
                  "picture sizes");
  const std::optional<IndexedImage> indexed = Index(image);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = indexed ? PNG_FORMAT_RGB_COLORMAP : PNG_FORMAT_RGB;
  if (indexed) png.colormap_entries = static_cast<png_uint_32>(indexed->colours.size() / 3);
  std::vector<std::uint8_t> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  const int written = png_image_write_to_memory(&png, bytes.data(), &size, 0,
                                                indexed ? indexed->pixels.data() : image.rgb.data(),
                                                0, indexed ? indexed->colours.data() : nullptr);
  BACKSIGHT_CHECK(written != 0, png.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace backsight
