#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "io/picture_record.h"
#include "io/png_image.h"

namespace backsight {

using Colour = std::array<std::uint8_t, 3>;

/// The part of a plane that a picture shows, and its pixels. Metres; y grows upwards.
struct PictureWindow {
  Eigen::Vector2d left_top = Eigen::Vector2d::Zero();
  double metres_per_pixel = 1.0;
  int width_px = 1;
  int height_px = 1;

  /// Shows `min` to `max` within the given pixels, with a little room around.
  static PictureWindow Around(const Eigen::Vector2d& min, const Eigen::Vector2d& max, int width_px,
                              int max_height_px);

  Eigen::Vector2d PixelOf(const Eigen::Vector2d& metres) const {
    return {(metres.x() - left_top.x()) / metres_per_pixel,
            (left_top.y() - metres.y()) / metres_per_pixel};
  }
  std::size_t size() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
  std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
           static_cast<std::size_t>(x);
  }

  /// Calls `body(x, y)` for the pixels whose middle lies within `reach_m` of `middle` along both
  /// axes, and for the one that holds it.
  template <typename Body>
  void ForEachPixel(const Eigen::Vector2d& middle, double reach_m, const Body& body) const;
};

/// So many stations have a colour of their own in a picture; the others share kOtherColour.
inline constexpr std::size_t kStationColours = 10;
inline constexpr Colour kOtherColour = {178, 178, 178};

/// Colours that also the colour-blind tell apart; `place` below kStationColours.
Colour StationColour(std::size_t place);

/// A scale from `low` to `high`, by equal steps or by equal factors; 64 colours. Values outside
/// have the colours of the ends.
class ColourScale {
 public:
  enum class Kind { kValues, kFactors };
  ColourScale(Kind kind, double low, double high);
  Colour Of(double value) const;
  PictureScale Record(const std::string& label) const;

 private:
  double Share(double value) const;
  Kind kind_;
  double low_, high_;
};

/// Fills in what the window and its pixels say.
PictureRecord MakePicture(PictureRecord::Kind kind, const PictureWindow& window,
                          const RgbImage& image);

/// 1, 2 or 5 times a power of ten, at least `value`, which is above 0.
double RoundUp(double value);

template <typename Body>
void PictureWindow::ForEachPixel(const Eigen::Vector2d& middle, double reach_m,
                                 const Body& body) const {
  const Eigen::Vector2d pixel = PixelOf(middle);
  const double reach = reach_m / metres_per_pixel;
  // Far outside, also for conversions to int.
  if (!(pixel.x() > -reach - 1.0 && pixel.y() > -reach - 1.0 && pixel.x() < width_px + reach &&
        pixel.y() < height_px + reach)) {
    return;
  }
  const auto first = [](double p, double r) {
    return static_cast<int>(std::max(0.0, std::min(std::floor(p), std::ceil(p - r - 0.5))));
  };
  const auto last = [](double p, double r, int size) {
    return static_cast<int>(
        std::min<double>(size - 1, std::max(std::floor(p), std::floor(p + r - 0.5))));
  };
  const int last_x = last(pixel.x(), reach, width_px);
  const int last_y = last(pixel.y(), reach, height_px);
  for (int y = first(pixel.y(), reach); y <= last_y; ++y) {
    for (int x = first(pixel.x(), reach); x <= last_x; ++x) body(x, y);
  }
}

}  // namespace backsight
