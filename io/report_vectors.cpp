#include "io/report_vectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/html_table.h"
#include "io/html_text.h"
#include "io/plot_sheet.h"

namespace backsight {
namespace {

std::string Mark(const SurveyPointRecord& point, const Eigen::Vector2d& p) {
  if (point.check) {
    return fmt::format("<circle class=\"check\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5.5\"/>\n", p.x(),
                       p.y());
  }
  return fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}l7 12h-14z\"/>\n",
                     point.excluded ? "excluded" : "control", p.x(), p.y() - 8);
}

/// In plan as an arrow, in height as a bar beside the mark, upwards where the network lies too
/// high.
std::string Vectors(const SurveyPointRecord& point, const Eigen::Vector2d& p, double pixels) {
  const Eigen::Vector3d v = pixels * point.residual_m;
  if (!v.allFinite()) throw InternalError("residual of survey point " + point.id);
  const Eigen::Vector2d tip = p + Eigen::Vector2d(v.x(), -v.y());
  std::string svg = fmt::format(
      "<path class=\"rise\" d=\"M{0:.1f} {1:.1f}v{2:.1f}\"/>\n"
      "<path class=\"vector\" d=\"M{3:.1f} {4:.1f}L{5:.1f} {6:.1f}\"/>\n",
      p.x() + 11, p.y(), -v.z(), p.x(), p.y(), tip.x(), tip.y());
  const Eigen::Vector2d along = tip - p;
  if (along.norm() < 6.0) return svg;
  const Eigen::Vector2d back = -6.0 * along.normalized();
  const Eigen::Vector2d aside(-0.5 * back.y(), 0.5 * back.x());
  const Eigen::Vector2d a = tip + back + aside, b = tip + back - aside;
  return svg + fmt::format(
                   "<path class=\"vector\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} "
                   "{:.1f}\"/>\n",
                   a.x(), a.y(), tip.x(), tip.y(), b.x(), b.y());
}

std::string Legend(double factor) {
  return fmt::format(
      "<div class=\"legend\"><span><svg width=\"18\" height=\"16\"><path class=\"control\" "
      "d=\"M9 2l7 12h-14z\"/></svg>control</span>\n<span><svg width=\"18\" height=\"16\"><path "
      "class=\"excluded\" d=\"M9 2l7 12h-14z\"/></svg>control, excluded</span>\n"
      "<span><svg width=\"16\" height=\"14\"><circle class=\"check\" cx=\"8\" cy=\"7\" r=\"5.5\"/>"
      "</svg>check</span>\n<span><svg width=\"14\" height=\"14\"><circle class=\"faint\" cx=\"7\" "
      "cy=\"7\" r=\"4\"/></svg>station</span>\n<span><svg width=\"34\" height=\"10\"><line "
      "class=\"vector\" x1=\"2\" y1=\"5\" x2=\"32\" y2=\"5\"/></svg>residual in plan</span>\n"
      "<span><svg width=\"14\" height=\"20\"><line class=\"rise\" x1=\"7\" y1=\"1\" x2=\"7\" "
      "y2=\"19\"/></svg>in height, upwards: too high</span>\n<span>{}</span></div>\n",
      factor > 0.0
          ? fmt::format("residuals drawn <b>{:g} times</b> too large, from the given place "
                        "towards the measured one; none of excluded points",
                        factor)
          : "all residuals are zero");
}

}  // namespace

std::string ResidualSvg(const RunRecord& run, const GeoreferenceRecord& georeference) {
  std::vector<Eigen::Vector2d> positions, stations;
  std::vector<double> lengths;
  for (const SurveyPointRecord& point : georeference.points) {
    positions.push_back(point.position.head<2>());
    // A blunder would make all others invisible.
    if (!point.excluded) lengths.push_back(point.residual_m.norm());
  }
  if (positions.empty()) return {};
  for (const PoseRecord& pose : run.poses) {
    if (!pose.ground || pose.component != georeference.component) continue;
    stations.push_back(pose.ground->position.head<2>());
    positions.push_back(stations.back());
  }
  const PlotSheet sheet(positions);
  const double factor = sheet.Exaggeration(lengths);
  std::string svg = sheet.Open("Control and check points with their residuals");
  for (const Eigen::Vector2d& station : stations) {
    const Eigen::Vector2d p = sheet.OnSheet(station);
    svg += fmt::format("<circle class=\"faint\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"/>\n", p.x(),
                       p.y());
  }
  std::vector<Eigen::Vector2d> marks;
  for (const SurveyPointRecord& point : georeference.points) {
    marks.push_back(sheet.OnSheet(point.position.head<2>()));
    svg += Mark(point, marks.back());
  }
  LabelPlacer labels(sheet, marks, 14.0);
  for (std::size_t i = 0; i < georeference.points.size(); ++i) {
    const SurveyPointRecord& point = georeference.points[i];
    if (!point.excluded) svg += Vectors(point, marks[i], factor * sheet.pixels_per_m());
    svg += labels.Label(marks[i], point.id);
  }
  return "<figure>\n" + svg + sheet.Close("E", "N") + Legend(factor) + "</figure>\n";
}

}  // namespace backsight
