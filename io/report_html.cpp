#include "io/report_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/report_distances.h"
#include "io/report_georeference.h"
#include "io/report_head.h"
#include "io/report_links.h"
#include "io/report_network.h"
#include "io/report_pictures.h"
#include "io/report_plan.h"
#include "io/report_style.h"
#include "io/report_tables.h"

namespace backsight {
namespace {

/// One plan for each component: they have no common frame. Lone stations are named only.
std::string Plans(const RunRecord& run) {
  std::map<int, std::vector<std::string>> components;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status == StationStatus::kRegistered) {
      components[pose.component].push_back(pose.station);
    }
  }
  if (components.empty()) return HtmlSentence("No station is registered.");
  std::string html;
  for (const auto& [component, stations] : components) {
    if (components.size() > 1) {
      html += fmt::format("<h3>Component {}: {} station{}</h3>\n", ComponentNumber(component),
                          stations.size(), stations.size() == 1 ? "" : "s");
    }
    html += stations.size() > 1 ? PlanSvg(run, component)
                                : HtmlSentence(HtmlText(stations.front()) + " stands alone.");
  }
  return html;
}

/// What the pictures leave out.
std::string OtherComponents(const RunRecord& run) {
  const auto elsewhere = std::count_if(run.poses.begin(), run.poses.end(), [](const auto& pose) {
    return pose.status == StationStatus::kRegistered && pose.component > 0;
  });
  if (elsewhere == 0) return {};
  return HtmlSentence(
      fmt::format("The pictures show component 1 alone, without the {} station{} of others.",
                  elsewhere, elsewhere == 1 ? "" : "s"));
}

std::string Result(const ReportDocument& document) {
  using Kind = PictureRecord::Kind;
  const std::string figures =
      PictureFigures(document, {Kind::kPlan, Kind::kSection, Kind::kDetail});
  if (figures.empty()) return HtmlSentence("There is no registered cloud to draw.");
  return OtherComponents(document.run) + figures;
}

std::string Section(const std::string& title, const std::string& content) {
  return "<h2>" + title + "</h2>\n" + content;
}

constexpr const char* kSignature =
    "<div class=\"sign\"><div>Place, date</div><div>Signature</div></div>\n";

}  // namespace

std::string ReportHtml(const ReportDocument& document) {
  const RunRecord& run = document.run;
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{} \xe2\x80\x93 registration report</title>\n<style>{}</style>\n</head>\n<body>\n",
      HtmlText(run.project_name), ReportStyle());
  html += ReportHead(document);
  html += Section("Network in plan", Plans(run));
  html += Section("Links", LinkTable(run) + LinkOriginTable(run));
  html += Section("Stations", StationTable(run));
  html += Section("Control and check points", GeoreferenceSection(run));
  html += Section("Adjustment of the network", NetworkSection(run));
  html += Section("The registered cloud", Result(document));
  html +=
      Section("Distances between the stations' surfaces",
              PictureFigures(document, {PictureRecord::Kind::kDistances}) + DistanceSection(run));
  html += Section("Scans", ScanTable(run));
  html += Section("Outputs", OutputTable(run));
  html += Section("What was rejected, and why", RejectedSection(document));
  return html + kSignature + "</body>\n</html>\n";
}

}  // namespace backsight
