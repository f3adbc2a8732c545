#include "core/range_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace backsight {

using std::numbers::pi;

RangeImage::RangeImage(const Eigen::Vector3d& origin, double pixel_deg)
    : origin_(origin),
      rows_(std::max(1, static_cast<int>(std::lround(180.0 / pixel_deg)))),
      columns_(2 * rows_),
      pixels_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_)) {}

void RangeImage::Add(const Eigen::Vector3d& point) {
  const auto range = static_cast<float>((point - origin_).norm());
  if (!(range > 0.0F)) return;
  Pixel& pixel = pixels_[Index(point)];
  if (pixel.min_m == 0.0F || range < pixel.min_m) pixel.min_m = range;
  pixel.max_m = std::max(pixel.max_m, range);
}

double RangeImage::Coverage() const {
  double seen = 0.0;
  double all = 0.0;
  for (int row = 0; row < rows_; ++row) {
    const double solid_angle = std::sin(pi * (row + 0.5) / rows_);
    for (int column = 0; column < columns_; ++column) {
      all += solid_angle;
      const auto index = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                         static_cast<std::size_t>(column);
      if (pixels_[index].max_m > 0.0F) seen += solid_angle;
    }
  }
  return all > 0.0 ? seen / all : 0.0;
}

std::size_t RangeImage::Index(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d d = point - origin_;
  const double azimuth = std::atan2(d.y(), d.x());
  const double polar = std::atan2(std::hypot(d.x(), d.y()), d.z());
  const int row = std::clamp(static_cast<int>(polar / pi * rows_), 0, rows_ - 1);
  const int column =
      std::clamp(static_cast<int>((azimuth + pi) / (2.0 * pi) * columns_), 0, columns_ - 1);
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(column);
}

}  // namespace backsight
