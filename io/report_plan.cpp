#include "io/report_plan.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "io/html_text.h"

namespace backsight {
namespace {

constexpr double kWidth = 960.0;
constexpr double kMinHeight = 260.0;
constexpr double kMaxHeight = 720.0;
constexpr double kMargin = 60.0;
constexpr double kFoot = 50.0;  // room for the scale bar below the stations

/// Positions of the stations of one component and their place on the sheet.
class PlanLayout {
 public:
  PlanLayout(const RunRecord& run, int component) {
    for (const PoseRecord& pose : run.poses) {
      if (pose.status != StationStatus::kRegistered || pose.component != component) continue;
      const Eigen::Vector2d xy = pose.survey_from_station.translation.head<2>();
      if (!xy.allFinite()) throw InternalError("plan view: position of " + pose.station);
      positions_[pose.station] = xy;
    }
    if (positions_.empty()) throw InternalError("plan view of a component without stations");
    Eigen::Vector2d min = positions_.begin()->second;
    Eigen::Vector2d max = min;
    for (const auto& [station, xy] : positions_) {
      min = min.cwiseMin(xy);
      max = max.cwiseMax(xy);
    }
    const Eigen::Vector2d extent = (max - min).cwiseMax(1.0);
    pixels_per_m_ = std::min((kWidth - 2 * kMargin) / extent.x(),
                             (kMaxHeight - 2 * kMargin - kFoot) / extent.y());
    height_ = std::max(kMinHeight, extent.y() * pixels_per_m_ + 2 * kMargin + kFoot);
    middle_m_ = 0.5 * (min + max);
  }

  const std::map<std::string, Eigen::Vector2d>& positions() const { return positions_; }
  double height() const { return height_; }
  double pixels_per_m() const { return pixels_per_m_; }
  bool Holds(const std::string& station) const { return positions_.contains(station); }
  Eigen::Vector2d OnSheet(const std::string& station) const {
    const Eigen::Vector2d offset = (positions_.at(station) - middle_m_) * pixels_per_m_;
    return {kWidth / 2 + offset.x(), (height_ - kFoot) / 2 - offset.y()};
  }

 private:
  std::map<std::string, Eigen::Vector2d> positions_;
  Eigen::Vector2d middle_m_ = Eigen::Vector2d::Zero();
  double pixels_per_m_ = 1.0;
  double height_ = kMinHeight;
};

std::string LinkClass(const LinkRecord& link) {
  if (link.status != LinkStatus::kAccepted) return "rejected";
  return fmt::format("accepted r{}", ResidualClass(link.network_residual_m));
}

std::string LinkLine(const LinkRecord& link, const PlanLayout& layout) {
  const Eigen::Vector2d a = layout.OnSheet(link.source);
  const Eigen::Vector2d b = layout.OnSheet(link.target);
  const std::string name = HtmlText(link.source + " \xe2\x80\x93 " + link.target);
  const std::string meaning =
      link.status == LinkStatus::kAccepted
          ? FixedText(1000 * link.network_residual_m, 1, "network_residual_m") + " mm"
          : HtmlText(ToString(link.status) + ": " + link.reason);
  std::string svg = fmt::format(
      "<line class=\"link {}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\">"
      "<title>{}: {}</title></line>\n",
      LinkClass(link), a.x(), a.y(), b.x(), b.y(), name, meaning);
  if (link.status == LinkStatus::kAccepted && link.loop_controlled == false) {
    const Eigen::Vector2d m = 0.5 * (a + b);
    svg += fmt::format(
        "<path class=\"noloop\" d=\"M{0:.1f} {1:.1f}l7 7l-7 7l-7 -7z\"><title>{2}: on no loop"
        "</title></path>\n",
        m.x(), m.y() - 7, name);
  }
  return svg;
}

/// The round length (1, 2 or 5 times a power of ten) that takes at most a quarter of the sheet.
double BarLength(double pixels_per_m) {
  const double longest = kWidth / 4 / pixels_per_m;
  const double decade = std::pow(10.0, std::floor(std::log10(longest)));
  for (const double step : {5.0, 2.0}) {
    if (step * decade <= longest) return step * decade;
  }
  return decade;
}

std::string ScaleBar(const PlanLayout& layout) {
  const double length_m = BarLength(layout.pixels_per_m());
  const double y = layout.height() - 24;
  const double right = kWidth - 24;
  return fmt::format(
      "<path class=\"axis\" d=\"M{0:.1f} {1:.1f}v8H{2:.1f}v-8\"/>"
      "<text class=\"note\" x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"middle\">{5:g} m</text>\n",
      right - length_m * layout.pixels_per_m(), y, right,
      right - length_m * layout.pixels_per_m() / 2, y - 2, length_m);
}

std::string Axes(const PlanLayout& layout) {
  const double y = layout.height() - 18;
  return fmt::format(
      "<path class=\"axis\" d=\"M24 {0:.1f}v-44m-4 8l4 -8l4 8M24 {0:.1f}h44m-8 -4l8 4l-8 4\"/>"
      "<text class=\"note\" x=\"74\" y=\"{1:.1f}\">x</text>"
      "<text class=\"note\" x=\"20\" y=\"{2:.1f}\">y</text>\n",
      y, y + 4, y - 50);
}

}  // namespace

int ResidualClass(double residual_m) {
  if (!std::isfinite(residual_m)) throw InternalError("network_residual_m is not finite");
  int index = 0;
  for (const double limit : kResidualClassesM) index += residual_m > limit ? 1 : 0;
  return index;
}

std::string PlanSvg(const RunRecord& run, int component) {
  const PlanLayout layout(run, component);
  std::string svg = fmt::format(
      "<svg class=\"plan\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" "
      "aria-label=\"Plan view of component {2}\">\n",
      kWidth, layout.height(), ComponentNumber(component));
  // Accepted links are drawn last, over the dashed ones.
  for (const bool accepted : {false, true}) {
    for (const LinkRecord& link : run.links) {
      if (link.status == LinkStatus::kSkipped) continue;
      if ((link.status == LinkStatus::kAccepted) != accepted) continue;
      if (layout.Holds(link.source) && layout.Holds(link.target)) svg += LinkLine(link, layout);
    }
  }
  for (const auto& [station, xy] : layout.positions()) {
    const Eigen::Vector2d p = layout.OnSheet(station);
    // Labels of stations near the right edge go to the left of their mark.
    const bool left = p.x() > kWidth - 2 * kMargin;
    svg += fmt::format(
        "<circle class=\"station\" cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"5\"/>"
        "<text class=\"label\" x=\"{2:.1f}\" y=\"{3:.1f}\" text-anchor=\"{4}\">{5}</text>\n",
        p.x(), p.y(), p.x() + (left ? -9 : 9), p.y() - 7, left ? "end" : "start",
        HtmlText(station));
  }
  return svg + Axes(layout) + ScaleBar(layout) + "</svg>\n";
}

}  // namespace backsight
