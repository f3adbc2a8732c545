#include "io/plot_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "io/html_text.h"

namespace backsight {
namespace {

constexpr double kMinHeight = 260.0;
constexpr double kMaxHeight = 860.0;
constexpr double kMargin = 70.0;
constexpr double kFoot = 50.0;  // for the scale bar below

}  // namespace

PlotSheet::PlotSheet(const std::vector<Eigen::Vector2d>& positions) {
  BACKSIGHT_CHECK(!positions.empty(), "a plan of nothing");
  Eigen::Vector2d min = positions.front();
  Eigen::Vector2d max = min;
  for (const Eigen::Vector2d& position : positions) {
    if (!position.allFinite()) throw InternalError("a position in plan is not finite");
    min = min.cwiseMin(position);
    max = max.cwiseMax(position);
  }
  const Eigen::Vector2d extent = (max - min).cwiseMax(1.0);
  pixels_per_m_ = std::min((kWidth - 2 * kMargin) / extent.x(),
                           (kMaxHeight - 2 * kMargin - kFoot) / extent.y());
  height_ = std::max(kMinHeight, (max - min).y() * pixels_per_m_ + 2 * kMargin + kFoot);
  middle_m_ = 0.5 * (min + max);
}

Eigen::Vector2d PlotSheet::OnSheet(const Eigen::Vector2d& position) const {
  const Eigen::Vector2d offset = (position - middle_m_) * pixels_per_m_;
  return {kWidth / 2 + offset.x(), (height_ - kFoot) / 2 - offset.y()};
}

std::string PlotSheet::Open(const std::string& label) const {
  return fmt::format(
      "<svg class=\"plan\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n", kWidth,
      height_, HtmlText(label));
}

std::string PlotSheet::Close(const std::string& across, const std::string& up) const {
  const double y = height_ - 18;
  return fmt::format(
             "<path class=\"axis\" d=\"M24 {0:.1f}v-44m-4 8l4 -8l4 8M24 {0:.1f}h44m-8 -4l8 4l-8 "
             "4\"/>"
             "<text class=\"note\" x=\"74\" y=\"{1:.1f}\">{3}</text>"
             "<text class=\"note\" x=\"20\" y=\"{2:.1f}\">{4}</text>\n",
             y, y + 4, y - 50, HtmlText(across), HtmlText(up)) +
         ScaleBarSvg(kWidth - 24, height_ - 16, pixels_per_m_, kWidth / 4) + "</svg>\n";
}

double PlotSheet::Exaggeration(std::vector<double> lengths_m) const {
  constexpr double kUsualPx = 22.0;
  constexpr double kLongestPx = 64.0;
  std::erase_if(lengths_m, [](double length) { return !(length > 0.0); });
  if (lengths_m.empty()) return 0.0;
  std::sort(lengths_m.begin(), lengths_m.end());
  const double usual = lengths_m[lengths_m.size() / 2];
  return RoundLength(std::min(kUsualPx / usual, kLongestPx / lengths_m.back()) / pixels_per_m_);
}

double LabelPlacer::Box::Overlap(const Box& other) const {
  const Eigen::Vector2d common = max.cwiseMin(other.max) - min.cwiseMax(other.min);
  return common.minCoeff() > 0.0 ? common.prod() : 0.0;
}

LabelPlacer::LabelPlacer(const PlotSheet& sheet, const std::vector<Eigen::Vector2d>& marks,
                         double font_px)
    : width_(PlotSheet::kWidth), height_(sheet.height()), font_px_(font_px) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(5.0);
  for (const Eigen::Vector2d& mark : marks) taken_.push_back({mark - half, mark + half});
}

std::string LabelPlacer::Label(const Eigen::Vector2d& mark, const std::string& text) {
  const double width = 0.62 * font_px_ * static_cast<double>(text.size());
  const double gap = 8.0;
  struct Place {
    Eigen::Vector2d corner;  // upper left of the text
    const char* anchor;
  };
  const Eigen::Vector2d size(width, 1.1 * font_px_);
  const double right = gap, left = -gap - width, middle = -width / 2;
  const double above = -gap - size.y(), below = gap, beside = -size.y() / 2;
  const Place places[] = {
      {{right, -size.y()}, "start"}, {{right, 0.0}, "start"},     {{left, -size.y()}, "end"},
      {{left, 0.0}, "end"},          {{middle, above}, "middle"}, {{middle, below}, "middle"},
      {{right, beside}, "start"},    {{left, beside}, "end"},     {{right, above}, "start"},
      {{right, below}, "start"},     {{left, above}, "end"},      {{left, below}, "end"}};
  const Place* best = nullptr;
  double least = std::numeric_limits<double>::max();
  for (const Place& place : places) {
    const Box box{mark + place.corner, mark + place.corner + size};
    double cost = box.min.x() < 2.0 || box.min.y() < 2.0 || box.max.x() > width_ - 2.0 ||
                          box.max.y() > height_ - 2.0
                      ? 1e6
                      : 0.0;
    for (const Box& other : taken_) cost += box.Overlap(other);
    if (cost >= least) continue;
    least = cost;
    best = &place;
  }
  const Eigen::Vector2d corner = mark + best->corner;
  taken_.push_back({corner, corner + size});
  const std::string_view anchor = best->anchor;
  const double x = anchor == "start" ? corner.x()
                   : anchor == "end" ? corner.x() + width
                                     : corner.x() + width / 2;
  return fmt::format(
      "<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" "
      "style=\"font-size:{:g}px\">{}</text>\n",
      x, corner.y() + 0.85 * font_px_, anchor, font_px_, HtmlText(text));
}

double RoundLength(double longest) {
  const double decade = std::pow(10.0, std::floor(std::log10(longest)));
  for (const double step : {5.0, 2.0}) {
    if (step * decade <= longest) return step * decade;
  }
  return decade;
}

std::string ScaleBarSvg(double right, double y, double pixels_per_m, double longest_px) {
  const double length_m = RoundLength(longest_px / pixels_per_m);
  const double left = right - length_m * pixels_per_m;
  return fmt::format(
      "<path class=\"axis\" d=\"M{0:.1f} {1:.1f}v8H{2:.1f}v-8\"/>"
      "<text class=\"note\" x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"middle\">{5}</text>\n",
      left, y - 8, right, (left + right) / 2, y - 6,
      length_m < 1.0 ? fmt::format("{:g} mm", 1000.0 * length_m) : fmt::format("{:g} m", length_m));
}

}  // namespace backsight
