#include "io/report_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/report_plan.h"

namespace backsight {
namespace {

/// What the covariance says of a station's place.
std::vector<std::string> SigmaCells(const PoseRecord& pose) {
  const auto covariance = ShownCovariance(pose);
  if (!covariance) return std::vector<std::string>(6);
  const RigidTransform& motion = ShownPose(pose);
  const PoseSigma sigma = SigmaOf(motion, *covariance);
  const ErrorEllipse ellipse = EllipseOf(motion, *covariance);
  const std::string field = "sigma of station " + pose.station;
  const auto mm = [&](double metres) { return FixedText(1000 * metres, 2, field); };
  const bool fixed = ellipse.semi_major_m == 0.0;  // the datum: no direction
  return {mm(sigma.worst_position_m), mm(ellipse.semi_major_m),
          mm(ellipse.semi_minor_m),   fixed ? "" : FixedText(ellipse.azimuth_deg, 0, field),
          mm(sigma.position_m.z()),   FixedText(sigma.rotation_deg.maxCoeff(), 4, field)};
}

/// What a cloud holds of the stations' points.
std::string SelectionText(const OutputRecord& output) {
  if (!output.points) return "";
  return output.selection.empty() ? "all" : HtmlText(output.selection);
}

/// A sentence that names the stations that are not in the table.
std::string Unplaced(const RunRecord& run) {
  std::string names;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status == StationStatus::kRegistered) continue;
    names += (names.empty() ? "" : ", ") + HtmlBold(pose.station);
  }
  return names.empty()
             ? ""
             : HtmlSentence("Not placed, reasons under what was rejected: " + names + ".");
}

}  // namespace

std::string StationTable(const RunRecord& run) {
  const bool on_ground = std::any_of(run.poses.begin(), run.poses.end(), [](const PoseRecord& p) {
    return p.status == StationStatus::kRegistered && p.ground;
  });
  HtmlTable table({{"station"},
                   {"compo&shy;nent", true},
                   {on_ground ? "E [m]" : "x [m]", true},
                   {on_ground ? "N [m]" : "y [m]", true},
                   {on_ground ? "H [m]" : "z [m]", true},
                   {"&sigma; position, worst direction [mm]", true},
                   {"ellipse a [mm]", true},
                   {"b [mm]", true},
                   {"azimuth of a [deg]", true},
                   {"&sigma; height [mm]", true},
                   {"&sigma; rotation, worst axis [deg]", true},
                   {"links", true}});
  bool any = false, in_survey_frame = false;
  for (const PoseRecord& pose : run.poses) {
    if (pose.status != StationStatus::kRegistered) continue;
    any = true;
    in_survey_frame = in_survey_frame || !pose.ground;
    std::vector<std::string> cells = {
        HtmlBold(pose.station) + (on_ground && !pose.ground ? "*" : ""),
        std::to_string(ComponentNumber(pose.component))};
    const Eigen::Vector3d position =
        pose.ground ? pose.ground->position : pose.survey_from_station.translation;
    for (int i = 0; i < 3; ++i) {
      cells.push_back(FixedText(position[i], 3, "position of station " + pose.station));
    }
    const std::vector<std::string> sigmas = SigmaCells(pose);
    cells.insert(cells.end(), sigmas.begin(), sigmas.end());
    cells.push_back(std::to_string(pose.link_count));
    table.Row(cells);
  }
  if (!any) return HtmlSentence("No station is registered.");
  return table.Finish() +
         HtmlSentence(fmt::format(
             "<span class=\"soft\">Formal standard deviations of the scanner's place, in the frame "
             "of the {}. Ellipse: semi-major and semi-minor axis of the horizontal standard error "
             "ellipse (39 % confidence; times 2.45 for 95 %), azimuth from {} clockwise. Links: "
             "accepted links of the station.{}</span>",
             on_ground ? "control" : "first station, which is fixed and has none",
             !on_ground         ? "the y axis"
             : IsTrueNorth(run) ? "true north (of the local frame; grid north differs by the "
                                  "convergence)"
                                : "north",
             on_ground && in_survey_frame ? " *: in its component's survey frame." : "")) +
         Unplaced(run);
}

std::string ScanTable(const RunRecord& run) {
  if (run.scans.empty()) return HtmlSentence("No scan was read.");
  HtmlTable table({{"station"},
                   {"file"},
                   {"format"},
                   {"records", true},
                   {"points", true},
                   {"dropped", true},
                   {"moving", true},
                   {"voxels", true},
                   {"keypoints", true},
                   {"extent [m]", true}});
  std::string notes;
  for (const ScanRecord& scan : run.scans) {
    table.Row({HtmlBold(scan.station), "<code>" + HtmlText(scan.path) + "</code>",
               HtmlText(scan.format), GroupedText(scan.records), GroupedText(scan.points),
               GroupedText(scan.dropped), GroupedText(scan.moving), GroupedText(scan.leaves),
               GroupedText(scan.keypoints),
               FixedText(scan.extent_m, 1, "extent_m of " + scan.station)});
    for (const std::string& note : scan.notes) {
      notes += "<li>" + HtmlBold(scan.station) + ": " + HtmlText(note) + "</li>\n";
    }
  }
  return table.Finish() + "<h3>Repairs and notes</h3>\n" +
         (notes.empty() ? HtmlSentence("None: the files were read as they are.")
                        : "<ul>\n" + notes + "</ul>\n");
}

std::string OutputTable(const RunRecord& run) {
  if (run.outputs.empty()) return HtmlSentence("Nothing was written.");
  HtmlTable table(
      {{"file"}, {"format"}, {"points", true}, {"which points within the range limits"}});
  for (const OutputRecord& output : run.outputs) {
    table.Row({"<code>" + HtmlText(output.path) + "</code>", HtmlText(output.format),
               output.points ? GroupedText(*output.points) : "", SelectionText(output)});
  }
  return table.Finish();
}

}  // namespace backsight
