#include "io/report_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/report_plan.h"

namespace backsight {
namespace {

std::string Card(const std::string& value, const std::string& meaning) {
  return fmt::format("<div class=\"card\"><b>{}</b><span>{}</span></div>\n", value, meaning);
}

/// "relative to S1": what the sigmas of a placed station's position are relative to.
std::string SigmaFrame(const RunRecord& run, const PoseRecord& pose) {
  if (pose.ground) return "on the ground";
  const auto datum = std::find_if(run.poses.begin(), run.poses.end(), [&](const PoseRecord& p) {
    return p.status == StationStatus::kRegistered && p.component == pose.component;
  });
  return "relative to " + HtmlText(datum->station);
}

std::string WorstSigmaCard(const RunRecord& run) {
  double worst = -1.0;
  const PoseRecord* station = nullptr;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status != StationStatus::kRegistered) continue;
    const auto covariance = ShownCovariance(pose);
    if (!covariance) continue;
    const double sigma = SigmaOf(ShownPose(pose), *covariance).worst_position_m;
    if (sigma > worst) {
      worst = sigma;
      station = &pose;
    }
  }
  if (station == nullptr) return {};
  return Card(FixedText(1000 * worst, 2, "sigma of station " + station->station) + " mm",
              fmt::format("worst formal &sigma; of a position: {}, {}", HtmlText(station->station),
                          SigmaFrame(run, *station)));
}

std::string WorstResidualCard(const RunRecord& run) {
  const LinkRecord* worst = nullptr;
  for (const LinkRecord& link : run.links) {
    if (link.status != LinkStatus::kAccepted || !link.network_residual_m) continue;
    if (worst == nullptr || *link.network_residual_m > *worst->network_residual_m) worst = &link;
  }
  if (worst == nullptr) return {};
  const std::string name = worst->source + " \xe2\x80\x93 " + worst->target;
  const std::string field = "residual of link " + name;
  const std::string sigmas =
      worst->network_residual_sigmas
          ? fmt::format(", {} of its &sigma;", FixedText(*worst->network_residual_sigmas, 1, field))
          : "";
  return Card(FixedText(1000 * *worst->network_residual_m, 1, field) + " mm",
              fmt::format("worst network residual: {}{}", HtmlText(name), sigmas));
}

std::string DistanceCard(const RunRecord& run) {
  if (!run.distances) return {};
  const DistanceFigures& total = run.distances->total;
  return Card(
      FixedText(1000 * total.p95_m, 1, "distances") + " mm",
      fmt::format("95 % of the {} compared surfaces are no further apart (median {} mm)",
                  GroupedText(total.samples), FixedText(1000 * total.median_m, 1, "distances")));
}

std::string CheckCard(const RunRecord& run) {
  const CheckRecord* worst = nullptr;
  for (const GeoreferenceRecord& g : run.georeference) {
    if (!g.placed() || g.check.points == 0) continue;
    if (worst == nullptr || g.check.rmse_3d_m > worst->rmse_3d_m) worst = &g.check;
  }
  if (worst == nullptr) return {};
  return Card(FixedText(1000 * worst->rmse_3d_m, 1, "rmse") + " mm",
              fmt::format("3D RMSE at check points, n = {}", worst->points));
}

/// "12 of 12" stations, or "9 + 3 of 12" where they do not hang together.
std::string PlacedCard(const RunRecord& run) {
  std::map<int, int> sizes;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status == StationStatus::kRegistered) ++sizes[pose.component];
  }
  constexpr std::size_t kShown = 3;
  std::vector<std::string> parts;
  parts.reserve(sizes.size());
  for (const auto& [component, size] : sizes) parts.push_back(std::to_string(size));
  const bool more = parts.size() > kShown;
  if (more) parts.resize(kShown);
  return Card(
      fmt::format("{}{} of {}", parts.empty() ? "0" : fmt::format("{}", fmt::join(parts, " + ")),
                  more ? " + &hellip;" : "", run.poses.size()),
      sizes.size() > 1 ? fmt::format("stations registered, in {} components that no link "
                                     "joins",
                                     sizes.size())
                       : "stations registered");
}

std::string Cards(const RunRecord& run) {
  const auto accepted = std::count_if(run.links.begin(), run.links.end(), [](const LinkRecord& l) {
    return l.status == LinkStatus::kAccepted;
  });
  const auto uncontrolled =
      std::count_if(run.links.begin(), run.links.end(), [](const LinkRecord& l) {
        return l.status == LinkStatus::kAccepted && l.loop_controlled == false;
      });
  std::string html = "<div class=\"cards\">\n";
  html += PlacedCard(run);
  html += Card(fmt::format("{} of {}", accepted, run.links.size()), "pairs tried were accepted");
  html += Card(fmt::format("{}", uncontrolled), "accepted links that no loop controls");
  html += WorstSigmaCard(run) + CheckCard(run) + DistanceCard(run);
  html += WorstResidualCard(run);
  return html + "</div>\n";
}

std::string Gates(const RunRecord& run) {
  if (run.gates.empty()) return HtmlSentence("The project file sets no quality gates.");
  HtmlTable table({{"quality gate"}, {"limit", true}, {"value", true}, {"result"}});
  for (const GateRecord& gate : run.gates) {
    table.Row({HtmlText(gate.name), HtmlText(gate.limit), HtmlText(gate.value),
               HtmlMark(gate.passed, gate.passed ? "passed" : "failed")});
  }
  return table.Finish();
}

/// What is said of components that are tied to the ground, or not, unlike the main one.
std::string OtherComponents(const RunRecord& run, bool placed) {
  std::string numbers;
  for (const GeoreferenceRecord& g : run.georeference) {
    if (g.component == 0 || g.placed() != placed) continue;
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(ComponentNumber(g.component));
  }
  if (numbers.empty()) return {};
  return placed ? fmt::format(" That is the main network; control ties component {} to <b>{}</b>.",
                              numbers, HtmlText(run.georeference.front().crs))
                : fmt::format(" <b>Not so component {}</b>, which stays in its own survey frame.",
                              numbers);
}

std::string Verdict(const RunRecord& run) {
  const std::size_t warnings = run.warnings.size();
  return fmt::format("<div class=\"verdict{}\">{}{}</div>\n", run.exit_code == 0 ? " pass" : "",
                     HtmlMark(run.exit_code == 0, run.verdict),
                     warnings == 0 ? ""
                                   : fmt::format(" <span class=\"soft\">{} warning{} below.</span>",
                                                 warnings, warnings == 1 ? "" : "s"));
}

std::string Warnings(const RunRecord& run) {
  if (run.warnings.empty()) return HtmlSentence("None.");
  std::string html = "<ul>\n";
  for (const std::string& warning : run.warnings) html += "<li>" + HtmlText(warning) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string FrameSentence(const RunRecord& run) {
  if (run.georeference.empty() || !run.georeference.front().placed()) {
    return "Coordinates: <b>survey frame</b>, a local frame in metres with the axes and the origin "
           "of the first station of each component. " +
           std::string(run.survey_points == 0
                           ? "The project gives no control: no reference system, no vertical datum."
                           : "Control did not tie it to the ground: no reference system, no "
                             "vertical datum.") +
           OtherComponents(run, /*placed=*/true);
  }
  const GeoreferenceRecord& g = run.georeference.front();
  if (!g.origin_deg_deg_m) {
    return "Coordinates: <b>" + HtmlText(g.crs) +
           "</b> in metres, a local grid: no map projection, heights in the control's own datum." +
           OtherComponents(run, /*placed=*/false);
  }
  return fmt::format(
             "Coordinates: <b>{}</b>; heights: <b>{}</b>. Way there: station &rarr; survey frame "
             "&rarr; local frame (east, north, up) on the ellipsoid &rarr; geographic &rarr; "
             "projection and height, point by point.",
             HtmlText(g.crs), HtmlText(g.heights.empty() ? "as given" : g.heights)) +
         OtherComponents(run, /*placed=*/false);
}

std::string ReportHead(const ReportDocument& document) {
  const RunRecord& run = document.run;
  return fmt::format(
             "<h1>{}</h1>\n<p class=\"soft\">Registration report, Backsight {}. What its figures "
             "mean and when to look twice: docs/method.md of Backsight.</p>\n"
             "<p class=\"frame\">{}</p>\n",
             HtmlText(run.project_name), HtmlText(run.version), FrameSentence(run)) +
         Verdict(run) + Cards(run) + Gates(run) + "<h2>Warnings</h2>\n" + Warnings(run);
}

}  // namespace backsight
