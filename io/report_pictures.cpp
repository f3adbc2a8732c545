#include "io/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/html_text.h"
#include "io/plot_sheet.h"

namespace backsight {
namespace {

constexpr double kLeft = 70.0;  // for ticks and their values
constexpr double kTop = 12.0;
constexpr double kBottom = 46.0;
constexpr double kScaleWidth = 126.0;

std::string Rgb(const std::array<std::uint8_t, 3>& rgb) {
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

/// Steps between ticks, metres, at least 90 pixels apart.
double TickStep(double metres_per_pixel) {
  const double least = 90.0 * metres_per_pixel;
  const double step = RoundLength(least);
  for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
    if (factor * step >= least * (1.0 - 1e-9)) return factor * step;
  }
  return 10.0 * step;
}

std::string TickText(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  const bool half = std::abs(step * std::pow(10.0, decimals) -
                             std::round(step * std::pow(10.0, decimals))) > 1e-6;
  return FixedText(value, decimals + (half ? 1 : 0), "tick");
}

/// Ticks and values along the lower and the left edge.
std::string Ticks(const PictureRecord& p) {
  const double step = TickStep(p.metres_per_pixel);
  const Eigen::Vector2d size(p.width_px * p.metres_per_pixel, p.height_px * p.metres_per_pixel);
  const double bottom = kTop + p.height_px;
  std::string svg;
  for (double k = std::ceil(p.left_top.x() / step); k * step <= p.left_top.x() + size.x(); ++k) {
    const double x = kLeft + (k * step - p.left_top.x()) / p.metres_per_pixel;
    svg += fmt::format(
        "<path class=\"tick\" d=\"M{0:.1f} {1:.1f}v6\"/><text class=\"note\" x=\"{0:.1f}\" "
        "y=\"{2:.1f}\" text-anchor=\"middle\">{3}</text>\n",
        x, bottom, bottom + 20, TickText(k * step, step));
  }
  for (double k = std::ceil((p.left_top.y() - size.y()) / step); k * step <= p.left_top.y(); ++k) {
    const double y = kTop + (p.left_top.y() - k * step) / p.metres_per_pixel;
    svg += fmt::format(
        "<path class=\"tick\" d=\"M{0:.1f} {1:.1f}h-6\"/><text class=\"note\" x=\"{2:.1f}\" "
        "y=\"{3:.1f}\" text-anchor=\"end\">{4}</text>\n",
        kLeft, y, kLeft - 9, y + 4.5, TickText(k * step, step));
  }
  return svg + fmt::format(
                   "<text class=\"note\" x=\"{0:.1f}\" y=\"{1:.1f}\" text-anchor=\"end\">"
                   "{2} [m]</text>\n<text class=\"note\" transform=\"translate(14 {3:.1f}) "
                   "rotate(-90)\" text-anchor=\"end\">{4} [m]</text>\n",
                   kLeft + p.width_px, bottom + 38, HtmlText(p.across), kTop + 2, HtmlText(p.up));
}

/// A scale bar on a white ground, so that it shows on every picture.
std::string Bar(const PictureRecord& p) {
  const double pixels_per_m = 1.0 / p.metres_per_pixel;
  const double longest = std::min(180.0, 0.4 * p.width_px);
  const double length = RoundLength(longest * p.metres_per_pixel) * pixels_per_m;
  const double right = kLeft + p.width_px - 14;
  const double y = kTop + p.height_px - 12;
  return fmt::format(
             "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"38\" fill=\"#fff\" "
             "fill-opacity=\".85\"/>\n",
             right - length - 8, y - 28, length + 16) +
         ScaleBarSvg(right, y, pixels_per_m, longest);
}

std::string Lines(const PictureRecord& p) {
  const auto at = [&](const Eigen::Vector2d& metres) {
    return Eigen::Vector2d(kLeft + (metres.x() - p.left_top.x()) / p.metres_per_pixel,
                           kTop + (p.left_top.y() - metres.y()) / p.metres_per_pixel);
  };
  std::string svg;
  for (const PictureLine& line : p.lines) {
    const Eigen::Vector2d from = at(line.from), to = at(line.to);
    if (!from.allFinite() || !to.allFinite()) throw InternalError("a line over " + p.title);
    const Eigen::Vector2d inwards = 14.0 * (to - from).normalized();
    const std::string name = HtmlText(line.label);
    svg += fmt::format(
        "<line class=\"cut\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{3:.1f}\"/>"
        "<text class=\"cutname\" x=\"{4:.1f}\" y=\"{5:.1f}\" text-anchor=\"middle\">{6}</text>"
        "<text class=\"cutname\" x=\"{7:.1f}\" y=\"{8:.1f}\" text-anchor=\"middle\">{6}\xe2\x80\xb2"
        "</text>\n",
        from.x(), from.y(), to.x(), to.y(), from.x() + inwards.x(), from.y() + inwards.y() - 4,
        name, to.x() - inwards.x(), to.y() - inwards.y() - 4);
  }
  return svg;
}

/// The value of a stop with as many decimals as tell it from its neighbour, three digits at least.
std::string StopText(const PictureScale& scale, std::size_t i) {
  const double value = scale.stops[i].value;
  const std::size_t other = i + 1 < scale.stops.size() ? i + 1 : i - 1;
  const double step = std::abs(scale.stops[other].value - value);
  const auto decimals = [](double size, double digits) {
    return size > 0.0 ? std::clamp(digits - 1.0 - std::floor(std::log10(size)), 0.0, 6.0) : 0.0;
  };
  const double wanted = std::max(decimals(step, 1.0), decimals(std::abs(value), 3.0));
  return FixedText(value, static_cast<int>(wanted), "colour scale");
}

/// Signs at the ends that stand for all beyond them.
std::string OpenEnd(const PictureScale& scale, std::size_t i) {
  if (i == 0 && scale.open_below) return "&le; ";
  if (i + 1 == scale.stops.size() && scale.open_above) return "&ge; ";
  return {};
}

/// A vertical bar of the colours, highest on top, beside the picture.
std::string ScaleSvg(const PictureRecord& p, std::size_t number) {
  const std::vector<PictureStop>& stops = p.scale->stops;
  if (stops.size() < 2) return {};
  const double x = kLeft + p.width_px + 18;
  const double top = kTop + 22;
  const double height = std::min(280.0, p.height_px - 30.0);
  std::string svg =
      fmt::format("<linearGradient id=\"s{}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">", number);
  const auto last = static_cast<double>(stops.size() - 1);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    svg += fmt::format("<stop offset=\"{:.3f}\" stop-color=\"{}\"/>", static_cast<double>(i) / last,
                       Rgb(stops[i].rgb));
  }
  svg += fmt::format(
      "</linearGradient>\n<text class=\"note\" x=\"{0:.1f}\" y=\"{1:.1f}\">{2}</text>"
      "<rect x=\"{0:.1f}\" y=\"{3:.1f}\" width=\"16\" height=\"{4:.1f}\" fill=\"url(#s{5})\"/>\n",
      x, kTop + 10, HtmlText(p.scale->label), top, height, number);
  for (std::size_t i = 0; i < stops.size(); i += 2) {
    FixedText(stops[i].value, 0, "colour scale of " + p.title);
    const double y = top + height * (1.0 - static_cast<double>(i) / last);
    svg += fmt::format(
        "<path class=\"tick\" d=\"M{0:.1f} {1:.1f}h5\"/><text class=\"note\" "
        "x=\"{2:.1f}\" y=\"{3:.1f}\">{4}</text>\n",
        x + 16, y, x + 25, y + 4.5, OpenEnd(*p.scale, i) + StopText(*p.scale, i));
  }
  return svg;
}

std::string Keys(const PictureRecord& p) {
  if (p.keys.empty()) return {};
  std::string html = "<div class=\"legend\">";
  for (const PictureKey& key : p.keys) {
    html += fmt::format("<span><i class=\"key\" style=\"background:{}\"></i>{}</span>\n",
                        Rgb(key.rgb), HtmlText(key.label));
  }
  return html + "</div>\n";
}

std::string Figure(const PictureRecord& p, std::size_t number) {
  if (!std::isfinite(p.metres_per_pixel) || !p.left_top.allFinite()) {
    throw InternalError("the scale of " + p.title);
  }
  const double width = kLeft + p.width_px + (p.scale ? kScaleWidth : 12.0);
  const double height = kTop + p.height_px + kBottom;
  std::string html = fmt::format(
      "<figure>\n<h3>{0}</h3>\n<svg class=\"picture {8}\" width=\"{1:.0f}\" height=\"{2:.0f}\" "
      "viewBox=\"0 0 {1:.0f} {2:.0f}\" role=\"img\" aria-label=\"{0}\">\n"
      "<image x=\"{3}\" y=\"{4}\" width=\"{5}\" height=\"{6}\" "
      "href=\"data:image/png;base64,{7}\"/>\n"
      "<rect class=\"axis\" x=\"{3}\" y=\"{4}\" width=\"{5}\" height=\"{6}\"/>\n",
      HtmlText(p.title), width, height, kLeft, kTop, p.width_px, p.height_px,
      HtmlText(p.png_base64), ToString(p.kind));
  html += Ticks(p) + Lines(p) + Bar(p);
  if (p.scale) html += ScaleSvg(p, number);
  return html + "</svg>\n" + Keys(p) + "<figcaption>" + HtmlText(p.caption) +
         "</figcaption>\n</figure>\n";
}

}  // namespace

std::string PictureFigures(const ReportDocument& document,
                           std::initializer_list<PictureRecord::Kind> kinds) {
  std::string html;
  for (std::size_t i = 0; i < document.pictures.size(); ++i) {
    if (std::find(kinds.begin(), kinds.end(), document.pictures[i].kind) == kinds.end()) continue;
    html += Figure(document.pictures[i], i);
  }
  return html;
}

}  // namespace backsight
