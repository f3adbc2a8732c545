#include "pipeline/picture_canvas.h"

#include "io/html_text.h"

namespace backsight {
namespace {

/// After Okabe and Ito: told apart by colour-blind readers too; yellow darkened for white paper.
constexpr Colour kPalette[kStationColours] = {
    {0, 114, 178},  {213, 94, 0},  {0, 158, 115},  {204, 121, 167}, {230, 159, 0},
    {86, 180, 233}, {110, 60, 20}, {120, 94, 240}, {60, 60, 60},    {150, 190, 20}};

/// Viridis, evenly spaced: it grows lighter evenly, in print too.
constexpr Colour kValueColours[] = {{68, 1, 84},    {71, 44, 122},  {59, 81, 139},
                                    {44, 113, 142}, {33, 144, 141}, {39, 173, 129},
                                    {92, 200, 99},  {170, 220, 50}, {253, 231, 37}};
constexpr std::size_t kAnchors = std::size(kValueColours);

Colour Blend(const Colour& a, const Colour& b, double share) {
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c) {
    colour[c] = static_cast<std::uint8_t>(std::lround((1.0 - share) * a[c] + share * b[c]));
  }
  return colour;
}

}  // namespace

PictureWindow PictureWindow::Around(const Eigen::Vector2d& min, const Eigen::Vector2d& max,
                                    int width_px, int max_height_px) {
  constexpr double kRoom = 0.03;  // of the larger side
  const double room = std::max(0.5, kRoom * (max - min).maxCoeff());
  const Eigen::Vector2d size = max - min + Eigen::Vector2d::Constant(2.0 * room);
  PictureWindow window;
  window.metres_per_pixel = std::max(size.x() / width_px, size.y() / max_height_px);
  window.width_px =
      std::clamp(static_cast<int>(std::ceil(size.x() / window.metres_per_pixel)), 1, width_px);
  window.height_px =
      std::clamp(static_cast<int>(std::ceil(size.y() / window.metres_per_pixel)), 1, max_height_px);
  window.left_top = {min.x() - room, max.y() + room};
  return window;
}

Colour StationColour(std::size_t place) { return kPalette[place]; }

ColourScale::ColourScale(Kind kind, double low, double high)
    : kind_(kind), low_(low), high_(std::max(high, low + 1e-6)) {}

double ColourScale::Share(double value) const {
  const double share = kind_ == Kind::kFactors
                           ? std::log(std::max(value, low_) / low_) / std::log(high_ / low_)
                           : (value - low_) / (high_ - low_);
  return std::clamp(share, 0.0, 1.0);
}

Colour ColourScale::Of(double value) const {
  constexpr double kSteps = 63.0;
  const double place = std::round(kSteps * Share(value)) / kSteps * (kAnchors - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kAnchors - 2);
  return Blend(kValueColours[below], kValueColours[below + 1], place - static_cast<double>(below));
}

PictureScale ColourScale::Record(const std::string& label) const {
  PictureScale scale;
  scale.label = label;
  for (std::size_t i = 0; i < kAnchors; ++i) {
    const double share = static_cast<double>(i) / (kAnchors - 1);
    const double value = kind_ == Kind::kFactors ? low_ * std::pow(high_ / low_, share)
                                                 : low_ + share * (high_ - low_);
    scale.stops.push_back({value, Of(value)});
  }
  return scale;
}

PictureRecord MakePicture(PictureRecord::Kind kind, const PictureWindow& window,
                          const RgbImage& image) {
  PictureRecord picture;
  picture.kind = kind;
  picture.width_px = window.width_px;
  picture.height_px = window.height_px;
  picture.metres_per_pixel = window.metres_per_pixel;
  picture.left_top = window.left_top;
  picture.png_base64 = Base64(EncodePng(image));
  return picture;
}

double RoundUp(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * decade >= value * (1.0 - 1e-9)) return step * decade;
  }
  return 10.0 * decade;
}

}  // namespace backsight
