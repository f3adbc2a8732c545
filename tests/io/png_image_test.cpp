#include "io/png_image.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cstdint>
#include <vector>

#include "core/error.h"

namespace backsight {
namespace {

RgbImage Gradient() {
  RgbImage image(320, 90, {255, 255, 255});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      image.Set(x, y, {static_cast<std::uint8_t>(x % 256), static_cast<std::uint8_t>(y), 7});
    }
  }
  return image;
}

std::vector<std::uint8_t> Decode(const std::vector<std::uint8_t>& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0);
  png.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(png));
  EXPECT_NE(png_image_finish_read(&png, nullptr, rgb.data(), 0, nullptr), 0);
  return rgb;
}

TEST(PngImage, DecodesToTheSamePixels) {
  const RgbImage image = Gradient();
  EXPECT_EQ(Decode(EncodePng(image)), image.rgb);
  EXPECT_EQ(image.At(5, 6), (std::array<std::uint8_t, 3>{5, 6, 7}));
  EXPECT_THROW(EncodePng({}), InternalError);
}

TEST(PngImage, FewColoursTakeAPalette) {
  RgbImage image(200, 100, {255, 255, 255});
  for (int x = 0; x < 200; ++x) image.Set(x, x / 2, {200, static_cast<std::uint8_t>(x % 7), 3});
  const std::vector<std::uint8_t> bytes = EncodePng(image);
  EXPECT_EQ(bytes[25], 3);  // colour type of the header: palette
  EXPECT_EQ(Decode(bytes), image.rgb);
}

}  // namespace
}  // namespace backsight
