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
      if (pixels_[Index(row, column)].max_m > 0.0F) seen += solid_angle;
    }
  }
  return all > 0.0 ? seen / all : 0.0;
}

std::size_t RangeImage::Measured() const {
  return static_cast<std::size_t>(std::count_if(
      pixels_.begin(), pixels_.end(), [](const Pixel& pixel) { return pixel.max_m > 0.0F; }));
}

double RangeImage::PixelAngle() const { return pi / rows_; }

RangeImage::Window RangeImage::Around(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d direction = point - origin_;
  const auto range = static_cast<float>(direction.norm());
  const auto [row, column] = Cell(direction);
  Window window;
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
    const double narrowing = std::sin(pi * (r + 0.5) / rows_);
    const int reach = std::min(static_cast<int>(std::lround(1.0 / narrowing)), columns_ / 2 - 1);
    for (int step = -std::max(reach, 0); step <= reach; ++step) {
      const int c = (column + step + columns_) % columns_;
      const Pixel& pixel = pixels_[Index(r, c)];
      if (pixel.max_m == 0.0F) continue;
      const float gap = std::min(std::abs(pixel.min_m - range), std::abs(pixel.max_m - range));
      const bool first = window.farthest_m == 0.0F;
      window.nearest_m = first ? pixel.min_m : std::min(window.nearest_m, pixel.min_m);
      window.gap_m = first ? gap : std::min(window.gap_m, gap);
      window.farthest_m = std::max(window.farthest_m, pixel.max_m);
    }
  }
  return window;
}

std::pair<int, int> RangeImage::Cell(const Eigen::Vector3d& d) const {
  const double azimuth = std::atan2(d.y(), d.x());
  const double polar = std::atan2(std::hypot(d.x(), d.y()), d.z());
  return {std::clamp(static_cast<int>(polar / pi * rows_), 0, rows_ - 1),
          std::clamp(static_cast<int>((azimuth + pi) / (2.0 * pi) * columns_), 0, columns_ - 1)};
}

std::size_t RangeImage::Index(const Eigen::Vector3d& point) const {
  const auto [row, column] = Cell(point - origin_);
  return Index(row, column);
}

}  // namespace backsight
