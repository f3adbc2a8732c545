#include "io/report_georeference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/report_vectors.h"

namespace backsight {
namespace {

std::string Mm(double metres, const std::string& field) {
  return FixedText(1000.0 * metres, 1, field);
}

std::string Chain(const GeoreferenceRecord& g) {
  const std::string field =
      fmt::format("georeference of component {}", ComponentNumber(g.component));
  std::string text;
  if (g.origin_deg_deg_m) {
    text += fmt::format(
        "Adjusted in a local frame (east, <b>true</b> north, up) at latitude {}&deg;, longitude "
        "{}&deg;, ellipsoidal height {} m; grid convergence there {}&deg; (grid north lies that "
        "much clockwise of true north), point scale {}. Each point is converted by itself, in "
        "clouds to 0.002 mm. ",
        FixedText(g.origin_deg_deg_m->x(), 7, field), FixedText(g.origin_deg_deg_m->y(), 7, field),
        FixedText(g.origin_deg_deg_m->z(), 3, field), FixedText(g.convergence_deg, 5, field),
        FixedText(g.point_scale, 7, field));
  }
  if (g.origin_crs_m) {
    text += fmt::format(
        "Its zero is E {}, N {}, H {} m. ", FixedText(g.origin_crs_m->x(), 3, field),
        FixedText(g.origin_crs_m->y(), 3, field), FixedText(g.origin_crs_m->z(), 3, field));
  }
  const std::string scale =
      g.scale_test ? fmt::format("{} &plusmn; {} ppm", FixedText(g.scale_test->off_ppm, 1, field),
                                 FixedText(g.scale_test->sigma_ppm, 1, field))
                   : "not tested, its adjustment did not converge";
  text +=
      fmt::format("Redundancy {}, variance factor {}. Scale against control: {}; applied: {} ppm.",
                  g.redundancy, FixedText(g.variance_factor, 2, field), scale,
                  FixedText(1e6 * (g.scale - 1.0), 1, field));
  return HtmlSentence(text);
}

/// The largest |w| of the axes that anything else checks, and those that nothing does.
std::string WorstW(const SurveyPointRecord& p, const std::string& field) {
  if (!p.w) return {};
  double worst = -1.0;
  std::string unchecked;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (p.checked[axis]) {
      worst = std::max(worst, std::abs((*p.w)[static_cast<Eigen::Index>(axis)]));
    } else {
      unchecked += "ENH"[axis];
    }
  }
  std::string text;
  if (worst >= 0.0) text = FixedText(worst, 2, field);
  if (!unchecked.empty()) text += HtmlMark(false, fmt::format("unchecked: {}", unchecked));
  return text;
}

std::string ControlTable(const GeoreferenceRecord& g) {
  HtmlTable table({{"control point"},
                   {"seen by", true},
                   {"free E [mm]", true},
                   {"free N [mm]", true},
                   {"free H [mm]", true},
                   {"E [mm]", true},
                   {"N [mm]", true},
                   {"H [mm]", true},
                   {"largest |w|", true},
                   {"use"}});
  for (const SurveyPointRecord& p : g.points) {
    if (p.check) continue;
    const std::string field = "control point " + p.id;
    std::vector<std::string> cells = {HtmlText(p.id), std::to_string(p.sightings)};
    for (int axis = 0; axis < 3; ++axis) {
      cells.push_back(p.free_residual_m ? Mm((*p.free_residual_m)[axis], field) : "");
    }
    for (int axis = 0; axis < 3; ++axis) cells.push_back(Mm(p.residual_m[axis], field));
    cells.push_back(WorstW(p, field));
    cells.push_back(HtmlMark(!p.excluded, p.excluded ? "blunder, excluded" : "used"));
    table.Row(cells, p.excluded ? "off" : "");
  }
  return table.Finish() +
         HtmlSentence(
             "<span class=\"soft\">Network less given coordinates. Free: the network moved as a "
             "whole. Then: network and control adjusted together. w: Baarda's standardised "
             "residual; unchecked: nothing else would show an error of this coordinate.</span>");
}

std::string CheckTable(const GeoreferenceRecord& g) {
  if (g.check.points == 0) {
    return HtmlSentence("No check points: nothing independent tests the coordinates.");
  }
  HtmlTable table({{"check point"},
                   {"seen by", true},
                   {"E [mm]", true},
                   {"N [mm]", true},
                   {"H [mm]", true},
                   {"predicted &sigma; E [mm]", true},
                   {"N [mm]", true},
                   {"H [mm]", true}});
  for (const SurveyPointRecord& p : g.points) {
    if (!p.check) continue;
    const std::string field = "check point " + p.id;
    std::vector<std::string> cells = {HtmlText(p.id), std::to_string(p.sightings)};
    for (int axis = 0; axis < 3; ++axis) cells.push_back(Mm(p.residual_m[axis], field));
    for (int axis = 0; axis < 3; ++axis) {
      cells.push_back(p.sigma_m ? Mm((*p.sigma_m)[axis], field) : "");
    }
    table.Row(cells);
  }
  const CheckRecord& c = g.check;
  constexpr int kAsprsPoints = 30;
  return table.Finish() +
         HtmlSentence(fmt::format(
             "RMSE E {} mm, N {} mm, H {} mm; horizontal {} mm, <b>3D {} mm</b> (predicted {} mm); "
             "n = {}{}.",
             Mm(c.rmse_m.x(), "rmse"), Mm(c.rmse_m.y(), "rmse"), Mm(c.rmse_m.z(), "rmse"),
             Mm(c.rmse_horizontal_m, "rmse"), Mm(c.rmse_3d_m, "rmse"), Mm(c.predicted_3d_m, "rmse"),
             c.points, c.points < kAsprsPoints ? ", not ASPRS-conformant (n &lt; 30)" : ""));
}

}  // namespace

std::string GeoreferenceSection(const RunRecord& run) {
  if (run.georeference.empty()) {
    return HtmlSentence(
        run.survey_points == 0
            ? "The project gives neither: nothing independent tests the coordinates."
            : fmt::format("The project gives {}, but there is no network that they "
                          "could tie to the ground.",
                          run.survey_points));
  }
  std::string html;
  for (const GeoreferenceRecord& g : run.georeference) {
    if (run.georeference.size() > 1) {
      html += fmt::format("<h3>Component {}</h3>\n", ComponentNumber(g.component));
    }
    if (!g.placed()) {
      html += HtmlSentence("Not tied to the ground: " + HtmlText(CodeWords(g.status)) +
                           ". It stays in its own survey frame.");
      continue;
    }
    html += Chain(g) + ResidualSvg(run, g) + ControlTable(g) + CheckTable(g);
  }
  return html;
}

}  // namespace backsight
