#include "core/range_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace backsight {

using std::numbers::pi;

namespace {

constexpr double kQuickError = 1e-7;  // rad, of QuickArcTangent

/// atan2, but for kQuickError (Abramowitz and Stegun 1964, 4.4.49: 2e-8); NaN at the origin.
double QuickArcTangent(double y, double x) {
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double t = std::min(ax, ay) / std::max(ax, ay);
  const double s = t * t;
  double sum = -0.0161657367 + s * 0.0028662257;
  sum = 0.0429096138 + s * sum;
  sum = -0.0752896400 + s * sum;
  sum = 0.1065626393 + s * sum;
  sum = -0.1420889944 + s * sum;
  sum = 0.1999355085 + s * sum;
  sum = -0.3333314528 + s * sum;
  double angle = t * (1.0 + s * sum);
  if (ay > ax) angle = 0.5 * pi - angle;
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

/// Whether a place in pixels lies so far from its pixel's edges that kQuickError does not matter.
bool IsInside(double place, double pixels_per_radian) {
  const double margin = 2.0 * kQuickError * pixels_per_radian;
  const double within = place - std::floor(place);
  return within > margin && within < 1.0 - margin;
}

}  // namespace

RangeImage::RangeImage(const Eigen::Vector3d& origin, double pixel_deg)
    : origin_(origin),
      rows_(std::max(1, static_cast<int>(std::lround(180.0 / pixel_deg)))),
      columns_(2 * rows_),
      pixels_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_)) {
  reach_.reserve(static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    const double narrowing = std::sin(pi * (row + 0.5) / rows_);
    const int reach = std::min(static_cast<int>(std::lround(1.0 / narrowing)), columns_ / 2 - 1);
    reach_.push_back(std::max(reach, 0));
  }
}

void RangeImage::Add(const Eigen::Vector3d& point) {
  const auto range = static_cast<float>((point - origin_).norm());
  if (!(range > 0.0F)) return;
  Pixel& pixel = pixels_[Index(point)];
  if (pixel.min_m == 0.0F || range < pixel.min_m) pixel.min_m = range;
  pixel.max_m = std::max(pixel.max_m, range);
}

void RangeImage::Add(const RangeImage& other) {
  BACKSIGHT_CHECK(origin_ == other.origin_ && rows_ == other.rows_, "images of other pixels");
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& from = other.pixels_[i];
    if (from.max_m == 0.0F) continue;
    Pixel& pixel = pixels_[i];
    if (pixel.min_m == 0.0F || from.min_m < pixel.min_m) pixel.min_m = from.min_m;
    pixel.max_m = std::max(pixel.max_m, from.max_m);
  }
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
  Window window{HUGE_VALF, 0.0F, HUGE_VALF, pixels_[Index(row, column)]};
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
    const int reach = reach_[static_cast<std::size_t>(r)];
    const Pixel* const pixels = pixels_.data() + Index(r, 0);
    const int first = column - reach;  // no farther than a whole turn outside
    const int end = column + reach + 1;
    Include(pixels + std::max(first, 0), std::min(end, columns_) - std::max(first, 0), range,
            &window);
    if (first < 0) Include(pixels + columns_ + first, -first, range, &window);
    if (end > columns_) Include(pixels, end - columns_, range, &window);
  }
  return window.farthest_m > 0.0F ? window : Window{};
}

void RangeImage::Include(const Pixel* pixels, int count, float range, Window* window) {
  for (const Pixel* pixel = pixels; pixel != pixels + count; ++pixel) {
    const bool empty = pixel->max_m == 0.0F;
    const float gap = std::min(std::abs(pixel->min_m - range), std::abs(pixel->max_m - range));
    window->nearest_m = std::min(window->nearest_m, empty ? HUGE_VALF : pixel->min_m);
    window->gap_m = std::min(window->gap_m, empty ? HUGE_VALF : gap);
    window->farthest_m = std::max(window->farthest_m, pixel->max_m);
  }
}

std::pair<int, int> RangeImage::Cell(const Eigen::Vector3d& d) const {
  const double per_radian = rows_ / pi;
  const double row = QuickArcTangent(std::sqrt(d.x() * d.x() + d.y() * d.y()), d.z()) * per_radian;
  const double column = (QuickArcTangent(d.y(), d.x()) + pi) * per_radian;
  if (IsInside(row, per_radian) && IsInside(column, per_radian)) {
    return {static_cast<int>(row), static_cast<int>(column)};
  }
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
