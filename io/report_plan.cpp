#include "io/report_plan.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "io/html_table.h"
#include "io/html_text.h"
#include "io/plot_sheet.h"

namespace backsight {
namespace {

/// More signs than this hide each other; then those of the largest sigmas are drawn.
constexpr std::size_t kMostDirections = 60;

using Poses = std::map<std::string, const PoseRecord*>;

Poses PosesOf(const RunRecord& run, int component) {
  Poses poses;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status == StationStatus::kRegistered && pose.component == component) {
      poses[pose.station] = &pose;
    }
  }
  return poses;
}

Eigen::Vector2d PlanPosition(const PoseRecord& pose) {
  const Eigen::Vector2d xy = ShownPose(pose).translation.head<2>();
  if (!xy.allFinite()) throw InternalError("plan view: position of " + pose.station);
  return xy;
}

/// One component's drawing.
class Plan {
 public:
  Plan(const RunRecord& run, Poses poses)
      : run_(run), poses_(std::move(poses)), sheet_(Positions(poses_)) {}

  std::string Links() const {
    std::string svg;
    // Accepted links are drawn last, over the dashed ones.
    for (const bool accepted : {false, true}) {
      for (const LinkRecord& link : run_.links) {
        if ((link.status == LinkStatus::kAccepted) == accepted && Holds(link)) svg += Line(link);
      }
    }
    return svg;
  }

  std::string WorstDirections() const {
    std::vector<const LinkRecord*> links;
    for (const LinkRecord& link : run_.links) {
      if (link.status == LinkStatus::kAccepted && link.worst_place && Holds(link)) {
        links.push_back(&link);
      }
    }
    std::stable_sort(links.begin(), links.end(), [](const LinkRecord* a, const LinkRecord* b) {
      return a->worst_place->sigma_m > b->worst_place->sigma_m;
    });
    if (links.size() > kMostDirections) links.resize(kMostDirections);
    std::string svg;
    for (const LinkRecord* link : links) svg += WorstDirection(*link);
    return svg;
  }

  /// Sets the factor by which they are exaggerated; 0: there is nothing to draw.
  std::string Ellipses(double* factor) const {
    std::vector<double> lengths;
    for (const auto& [station, pose] : poses_) {
      if (const auto covariance = ShownCovariance(*pose)) {
        lengths.push_back(EllipseOf(ShownPose(*pose), *covariance).semi_major_m);
      }
    }
    *factor = sheet_.Exaggeration(lengths);
    if (*factor == 0.0) return {};
    std::string svg;
    for (const auto& [station, pose] : poses_) svg += Ellipse(*pose, *factor);
    return svg;
  }

  std::string Stations() const {
    std::vector<Eigen::Vector2d> marks;
    for (const auto& [station, pose] : poses_) marks.push_back(OnSheet(station));
    const bool many = poses_.size() > 40;
    LabelPlacer labels(sheet_, marks, many ? 10.0 : 14.0);
    std::string svg;
    for (const Eigen::Vector2d& p : marks) {
      svg += fmt::format("<circle class=\"station\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>\n",
                         p.x(), p.y(), many ? 3.5 : 5);
    }
    for (const auto& [station, pose] : poses_) svg += labels.Label(OnSheet(station), station);
    return svg;
  }

  const PlotSheet& sheet() const { return sheet_; }
  bool on_ground() const { return poses_.begin()->second->ground.has_value(); }

 private:
  static std::vector<Eigen::Vector2d> Positions(const Poses& poses) {
    std::vector<Eigen::Vector2d> positions;
    for (const auto& [station, pose] : poses) positions.push_back(PlanPosition(*pose));
    return positions;
  }
  bool Holds(const LinkRecord& link) const {
    return link.status != LinkStatus::kSkipped && poses_.contains(link.source) &&
           poses_.contains(link.target);
  }
  Eigen::Vector2d OnSheet(const std::string& station) const {
    return sheet_.OnSheet(PlanPosition(*poses_.at(station)));
  }

  std::string Line(const LinkRecord& link) const {
    const bool accepted = link.status == LinkStatus::kAccepted;
    const Eigen::Vector2d a = OnSheet(link.source);
    const Eigen::Vector2d b = OnSheet(link.target);
    const std::string name = HtmlText(link.source + " \xe2\x80\x93 " + link.target);
    const double residual_m = link.network_residual_m.value_or(0.0);
    const std::string meaning = accepted
                                    ? FixedText(1000 * residual_m, 1, "network_residual_m") + " mm"
                                    : HtmlText(ToString(link.status) + ": " + link.reason);
    std::string svg = fmt::format(
        "<line class=\"link {}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\">"
        "<title>{}: {}</title></line>\n",
        accepted ? fmt::format("accepted r{}", ResidualClass(residual_m)) : "rejected", a.x(),
        a.y(), b.x(), b.y(), name, meaning);
    if (accepted && link.loop_controlled == false) {
      const Eigen::Vector2d m = a + 0.35 * (b - a);
      svg += fmt::format(
          "<path class=\"noloop\" d=\"M{0:.1f} {1:.1f}l7 7l-7 7l-7 -7z\"><title>{2}: on no loop"
          "</title></path>\n",
          m.x(), m.y() - 7, name);
    }
    return svg;
  }

  std::string WorstDirection(const LinkRecord& link) const {
    constexpr double kHalfLength = 15.0;
    const Eigen::Vector2d middle = 0.5 * (OnSheet(link.source) + OnSheet(link.target));
    const Eigen::Vector3d direction =
        ShownPose(*poses_.at(link.target)).rotation * link.worst_place->direction;
    const std::string title =
        fmt::format("<title>{}: {} mm in its worst direction</title>",
                    HtmlText(link.source + " \xe2\x80\x93 " + link.target),
                    FixedText(1000 * link.worst_place->sigma_m, 2, "worst sigma of the place"));
    if (std::abs(direction.z()) > 0.9) {
      return fmt::format("<circle class=\"weak\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\">{}</circle>\n",
                         middle.x(), middle.y(), title);
    }
    const Eigen::Vector2d half = kHalfLength * Eigen::Vector2d(direction.x(), -direction.y());
    return fmt::format(
        "<line class=\"weak\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\">{}</line>\n",
        middle.x() - half.x(), middle.y() - half.y(), middle.x() + half.x(), middle.y() + half.y(),
        title);
  }

  std::string Ellipse(const PoseRecord& pose, double factor) const {
    const auto covariance = ShownCovariance(pose);
    if (!covariance) return {};
    const ErrorEllipse ellipse = EllipseOf(ShownPose(pose), *covariance);
    const double pixels = factor * sheet_.pixels_per_m();
    if (ellipse.semi_major_m * pixels < 0.5) return {};
    const Eigen::Vector2d p = OnSheet(pose.station);
    return fmt::format(
        "<ellipse class=\"sigma\" rx=\"{0:.2f}\" ry=\"{1:.2f}\" "
        "transform=\"translate({2:.1f} {3:.1f}) rotate({4:.1f})\"/>\n",
        ellipse.semi_major_m * pixels, std::max(0.3, ellipse.semi_minor_m * pixels), p.x(), p.y(),
        ellipse.azimuth_deg - 90.0);
  }

  const RunRecord& run_;
  Poses poses_;
  PlotSheet sheet_;
};

std::string LegendLine(const std::string& line_class, const std::string& meaning) {
  return fmt::format(
      "<span><svg width=\"34\" height=\"10\"><line class=\"link {}\" x1=\"2\" y1=\"5\" x2=\"32\" "
      "y2=\"5\"/></svg>{}</span>\n",
      line_class, meaning);
}

/// What colours and signs mean.
std::string Legend() {
  const auto& limits = kResidualClassesM;
  const auto mm = [](double value) { return fmt::format("{:g}", 1000 * value); };
  std::string html = "<div class=\"legend\"><span>link less adjusted network:</span>\n";
  html += LegendLine("r0", "up to " + mm(limits[0]) + " mm");
  html += LegendLine("r1", "up to " + mm(limits[1]) + " mm");
  html += LegendLine("r2", "up to " + mm(limits[2]) + " mm");
  html += LegendLine("r3", "above " + mm(limits[2]) + " mm");
  html += LegendLine("rejected", "doubtful, rejected or failed");
  html +=
      "<span><svg width=\"18\" height=\"18\"><path class=\"noloop\" d=\"M9 2l7 7l-7 7l-7 -7z\"/>"
      "</svg>uncontrolled: on no loop</span>\n";
  html +=
      "<span><svg width=\"34\" height=\"12\"><line class=\"weak\" x1=\"4\" y1=\"6\" x2=\"30\" "
      "y2=\"6\"/></svg>where a pair alone knows the place of its source least (shorter: partly "
      "vertical; "
      "<svg width=\"14\" height=\"14\"><circle class=\"weak\" cx=\"7\" cy=\"7\" "
      "r=\"5\"/></svg>: vertical)</span>\n";
  return html + fmt::format(
                    "<span><svg width=\"30\" height=\"14\"><ellipse class=\"sigma\" "
                    "cx=\"15\" cy=\"7\" rx=\"12\" ry=\"5\"/></svg>error ellipse</span></div>"
                    "\n");
}

}  // namespace

int ResidualClass(double residual_m) {
  if (!std::isfinite(residual_m)) throw InternalError("network_residual_m is not finite");
  int index = 0;
  for (const double limit : kResidualClassesM) index += residual_m > limit ? 1 : 0;
  return index;
}

const RigidTransform& ShownPose(const PoseRecord& pose) {
  return pose.ground ? pose.ground->enu_from_station : pose.survey_from_station;
}

std::optional<Matrix6d> ShownCovariance(const PoseRecord& pose) {
  return pose.ground ? std::optional(pose.ground->covariance) : pose.covariance;
}

bool IsTrueNorth(const RunRecord& run) {
  return std::any_of(run.georeference.begin(), run.georeference.end(),
                     [](const GeoreferenceRecord& g) { return g.origin_deg_deg_m.has_value(); });
}

std::string PlanSvg(const RunRecord& run, int component) {
  Poses poses = PosesOf(run, component);
  if (poses.empty()) throw InternalError("plan view of a component without stations");
  const Plan plan(run, std::move(poses));
  double factor = 0.0;
  const std::string ellipses = plan.Ellipses(&factor);
  const std::string local = IsTrueNorth(run) ? "local " : "";
  const std::string svg =
      plan.sheet().Open(fmt::format("Plan view of component {}", ComponentNumber(component))) +
      plan.Links() + ellipses + plan.WorstDirections() + plan.Stations() +
      (plan.on_ground() ? plan.sheet().Close(local + "E", local + "N")
                        : plan.sheet().Close("x", "y"));
  const std::string ellipse_note =
      factor > 0.0 ? fmt::format(
                         "Error ellipses (one standard deviation, horizontal) are drawn "
                         "<b>{:g} times</b> too large.",
                         factor)
                   : "No station has an error ellipse.";
  const std::string north_note =
      plan.on_ground() && IsTrueNorth(run)
          ? " Up is true north in the local frame amid the control; grid north differs by the "
            "convergence stated under control."
          : "";
  return "<figure>\n" + svg + Legend() +
         HtmlSentence("<span class=\"soft\">" + ellipse_note + north_note + "</span>") +
         "</figure>\n";
}

}  // namespace backsight
