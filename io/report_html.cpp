#include "io/report_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/html_text.h"
#include "io/report_georeference.h"
#include "io/report_network.h"
#include "io/report_plan.h"
#include "io/report_tables.h"

namespace backsight {
namespace {

// Colours after Okabe and Ito, distinct under the common colour-vision deficiencies; line widths
// repeat what colours say.
constexpr std::string_view kStyle = R"(
:root { --good: #00664d; --bad: #a33c00; --line: #d5d9de; --soft: #5a6470; }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif;
  color: #1a1f26; background: #fff; max-width: 1180px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { font-size: 27px; line-height: 1.2; margin: 0 0 2px; }
h2 { font-size: 19px; margin: 36px 0 8px; border-bottom: 2px solid var(--line); }
h3 { font-size: 16px; margin: 18px 0 6px; }
p { margin: 6px 0; }
.soft { color: var(--soft); }
.verdict { border-left: 7px solid var(--bad); background: #fbf1eb; font-size: 18px;
  padding: 12px 16px; margin: 18px 0; }
.verdict.pass { border-color: var(--good); background: #ebf6f2; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(160px, 1fr)); gap: 10px;
  margin: 16px 0; }
.card { border: 1px solid var(--line); border-radius: 6px; padding: 9px 13px; }
.card b { display: block; font-size: 23px; line-height: 1.3; font-variant-numeric: tabular-nums; }
.card span { color: var(--soft); font-size: 13px; display: block; line-height: 1.35; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; min-width: 45%; margin: 8px 0; }
th { text-align: left; vertical-align: bottom; border-bottom: 1.5px solid #1a1f26; line-height: 1.25;
  padding: 4px 16px 4px 0; font-weight: 600; }
td { border-bottom: 1px solid var(--line); padding: 4px 16px 4px 0; vertical-align: top; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
td.n { white-space: nowrap; }
.off td { background: #f6f6f4; }
.good { color: var(--good); white-space: nowrap; }
.bad { color: var(--bad); font-weight: 600; white-space: nowrap; }
code { font-size: 12px; overflow-wrap: anywhere; }
svg.plan { width: 100%; height: auto; border: 1px solid var(--line); background: #fff; }
.link { stroke-linecap: round; }
.rejected { stroke: #8a9099; stroke-width: 1.3; stroke-dasharray: 5 6; }
.r0 { stroke: #0072b2; stroke-width: 1.8; }
.r1 { stroke: #009e73; stroke-width: 2.8; }
.r2 { stroke: #e69f00; stroke-width: 4; }
.r3 { stroke: #d55e00; stroke-width: 5.5; }
.noloop { fill: #fff; stroke: #a33c00; stroke-width: 2; }
.station { fill: #1a1f26; stroke: #fff; stroke-width: 1.5; }
.label { font: 600 13px system-ui, sans-serif; paint-order: stroke; stroke: #fff; stroke-width: 4; }
.note { font: 13px system-ui, sans-serif; fill: #414a55; }
.axis { fill: none; stroke: #414a55; stroke-width: 1.5; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 22px; font-size: 13px; align-items: center; }
.legend svg { vertical-align: middle; margin-right: 6px; }
.key { display: inline-block; width: 9px; height: 9px; margin-right: 6px; border-radius: 2px; }
.key.r0 { background: #0072b2; } .key.r1 { background: #009e73; }
.key.r2 { background: #e69f00; } .key.r3 { background: #d55e00; }
figure { margin: 14px 0; break-inside: avoid; }
figure img { max-width: 100%; height: auto; border: 1px solid var(--line); }
figcaption { font-size: 13px; color: var(--soft); }
@media print {
  body { font-size: 10.5pt; max-width: none; padding: 0; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h2, h3 { break-after: avoid; }
  tr, .card, svg { break-inside: avoid; }
  svg.plan { max-height: 150mm; }
  thead { display: table-header-group; }
  .scroll { overflow: visible; }
  table { font-size: 8pt; }
  th, td { padding-right: 8px; }
  td.n { white-space: normal; }
}
@page { size: A4 landscape; margin: 14mm; }
)";

std::string Card(const std::string& value, const std::string& meaning) {
  return fmt::format("<div class=\"card\"><b>{}</b><span>{}</span></div>\n", value, meaning);
}

std::string WorstSigmaCard(const RunRecord& run) {
  double worst = -1.0;
  std::string station;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status != StationStatus::kRegistered) continue;
    const std::optional<PoseSigma> sigma = SigmaOf(pose);
    if (sigma && sigma->worst_position_m > worst) {
      worst = sigma->worst_position_m;
      station = pose.station;
    }
  }
  if (worst < 0.0) return {};
  return Card(FixedText(1000 * worst, 2, "sigma of station " + station) + " mm",
              "worst formal &sigma; of a position: " + HtmlText(station));
}

/// `figure` of the accepted link where it is largest.
std::string WorstLinkCard(const RunRecord& run, double LinkRecord::*figure,
                          const std::string& meaning) {
  const LinkRecord* worst = nullptr;
  for (const LinkRecord& link : run.links) {
    if (link.status != LinkStatus::kAccepted) continue;
    if (worst == nullptr || link.*figure > worst->*figure) worst = &link;
  }
  if (worst == nullptr) return {};
  const std::string name = worst->source + " \xe2\x80\x93 " + worst->target;
  return Card(FixedText(1000 * worst->*figure, 1, meaning + " of link " + name) + " mm",
              meaning + ": " + HtmlText(name));
}

std::string Summary(const RunRecord& run) {
  const auto placed = std::count_if(run.poses.begin(), run.poses.end(), [](const PoseRecord& p) {
    return p.status == StationStatus::kRegistered;
  });
  const auto accepted = std::count_if(run.links.begin(), run.links.end(), [](const LinkRecord& l) {
    return l.status == LinkStatus::kAccepted;
  });
  const auto uncontrolled =
      std::count_if(run.links.begin(), run.links.end(), [](const LinkRecord& l) {
        return l.status == LinkStatus::kAccepted && l.loop_controlled == false;
      });
  const auto tried = std::count_if(run.links.begin(), run.links.end(), [](const LinkRecord& l) {
    return l.status != LinkStatus::kSkipped;
  });
  std::string html = "<div class=\"cards\">\n";
  html += Card(fmt::format("{} of {}", placed, run.poses.size()), "stations registered");
  html += Card(fmt::format("{} of {}", accepted, tried), "pairs tried were accepted");
  html += Card(fmt::format("{}", uncontrolled), "accepted links that no loop controls");
  html += WorstSigmaCard(run);
  html += WorstLinkCard(run, &LinkRecord::network_residual_m, "worst network residual");
  html += WorstLinkCard(run, &LinkRecord::rms_m, "worst point-to-plane rms");
  return html + "</div>\n";
}

std::string LegendLine(const std::string& line_class, const std::string& meaning) {
  return fmt::format(
      "<span><svg width=\"34\" height=\"10\"><line class=\"link {}\" x1=\"2\" y1=\"5\" x2=\"32\" "
      "y2=\"5\"/></svg>{}</span>\n",
      line_class, meaning);
}

std::string Legend() {
  const auto& limits = kResidualClassesM;
  const auto mm = [](double value) { return fmt::format("{:g}", 1000 * value); };
  std::string html = "<div class=\"legend\"><span>network residual:</span>\n";
  html += LegendLine("r0", "up to " + mm(limits[0]) + " mm");
  html += LegendLine("r1", "up to " + mm(limits[1]) + " mm");
  html += LegendLine("r2", "up to " + mm(limits[2]) + " mm");
  html += LegendLine("r3", "above " + mm(limits[2]) + " mm");
  html += LegendLine("rejected", "rejected or failed");
  return html +
         "<span><svg width=\"18\" height=\"18\"><path class=\"noloop\" d=\"M9 2l7 7l-7 7l-7 -7z\"/>"
         "</svg>on no loop</span></div>\n";
}

/// One plan for each component: they have no common frame. Lone stations are named only.
std::string Plans(const RunRecord& run) {
  std::map<int, std::vector<std::string>> components;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status == StationStatus::kRegistered) {
      components[pose.component].push_back(pose.station);
    }
  }
  if (components.empty()) return "<p>No station is registered.</p>\n";
  std::string html =
      "<p class=\"soft\">Seen from above in the survey frame, x to the right, y up, to "
      "scale.</p>\n";
  html += Legend();
  for (const auto& [component, stations] : components) {
    if (components.size() > 1) {
      html += fmt::format("<h3>Component {}: {} station{}</h3>\n", ComponentNumber(component),
                          stations.size(), stations.size() == 1 ? "" : "s");
    }
    html += stations.size() > 1 ? PlanSvg(run, component)
                                : "<p>" + HtmlText(stations.front()) + " stands alone.</p>\n";
  }
  return html;
}

std::string Warnings(const RunRecord& run) {
  if (run.warnings.empty()) return "<p>None.</p>\n";
  std::string html = "<ul>\n";
  for (const std::string& warning : run.warnings) html += "<li>" + HtmlText(warning) + "</li>\n";
  return html + "</ul>\n";
}

std::string Pictures(const std::vector<ReportPicture>& pictures) {
  if (pictures.empty()) return {};
  std::string html = "<h2>Pictures</h2>\n";
  for (const ReportPicture& picture : pictures) {
    html += fmt::format(
        "<figure><h3>{0}</h3><img alt=\"{0}\" src=\"data:image/png;base64,{1}\">"
        "<figcaption>{2}</figcaption></figure>\n",
        HtmlText(picture.title), Base64(picture.png), HtmlText(picture.caption));
  }
  return html;
}

}  // namespace

std::string ReportHtml(const RunRecord& run, const std::vector<ReportPicture>& pictures) {
  const std::string name = HtmlText(run.project_name);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{} \xe2\x80\x93 registration report</title>\n<style>{}</style>\n</head>\n<body>\n",
      name, kStyle);
  html += fmt::format("<h1>{}</h1>\n<p class=\"soft\">Registration report, Backsight {}</p>\n",
                      name, HtmlText(run.version));
  html += fmt::format("<div class=\"verdict{}\">{}</div>\n", run.exit_code == 0 ? " pass" : "",
                      HtmlText(run.verdict));
  html += Summary(run);
  html += "<h2>Quality gates</h2>\n" + GateTable(run);
  html += "<h2>Warnings</h2>\n" + Warnings(run);
  html += GeoreferenceSection(run);
  html += "<h2>Plan view</h2>\n" + Plans(run);
  html += "<h2>Stations</h2>\n" + StationTable(run);
  html += "<h2>Links</h2>\n" + LinkTable(run);
  html += "<h2>Network</h2>\n" + NetworkSection(run);
  html += "<h2>Scans</h2>\n" + ScanTable(run);
  html += "<h2>Outputs</h2>\n" + OutputTable(run);
  return html + Pictures(pictures) + "</body>\n</html>\n";
}

}  // namespace backsight
