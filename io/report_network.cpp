#include "io/report_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/median.h"
#include "io/html_table.h"
#include "io/html_text.h"

namespace backsight {
namespace {

/// Two tables, since one would be wider than paper: of the links, and of the planes.
std::string ComponentTable(const RunRecord& run) {
  HtmlTable links({{"component", true},
                   {"stations", true},
                   {"links", true},
                   {"redundancy", true},
                   {"links' &sigma; factor", true},
                   {"least determined"},
                   {"&sigma; there [mm]", true}});
  HtmlTable planes({{"component", true},
                    {"planes of all stations"},
                    {"planes", true},
                    {"observations", true},
                    {"rounds", true},
                    {"iterations", true},
                    {"planes' &sigma; factor", true}});
  const auto figure = [](const std::optional<double>& value, double factor,
                         const std::string& field) {
    return value ? FixedText(factor * *value, 2, field) : std::string();
  };
  for (const ComponentRecord& c : run.components) {
    const std::string number = std::to_string(ComponentNumber(c.component));
    const std::string field = "component " + number;
    links.Row({number, std::to_string(c.stations), std::to_string(c.links),
               std::to_string(c.redundancy), FixedText(c.sigma_factor, 2, field),
               HtmlText(c.weakest_station), figure(c.weakest_sigma_m, 1000.0, field)});
    planes.Row({number, HtmlText(CodeWords(c.refinement)), std::to_string(c.planes),
                std::to_string(c.observations), std::to_string(c.rounds),
                std::to_string(c.iterations), figure(c.plane_sigma_factor, 1.0, field)});
  }
  return links.Finish() + planes.Finish() +
         HtmlSentence(
             "<span class=\"soft\">The links' &sigma; factor is one for all components. Least "
             "determined: the motion of all stations of the component together that is known "
             "least, its &sigma; over all of them, rotations counted by the shift that they cause "
             "at the planes, and the station that it moves most. The &sigma; of single positions "
             "are in the table of stations.</span>");
}

/// Median and largest misclosure, and the worst triangles by name.
std::string ClosureTable(const RunRecord& run) {
  if (run.closures.empty()) {
    return HtmlSentence("No three stations are joined by a triangle of links.");
  }
  HtmlTable table({{"triangles"},
                   {"coarse [mm]", true},
                   {"coarse [deg]", true},
                   {"refined [mm]", true},
                   {"refined [deg]", true}});
  const auto median = [&](double ClosureRecord::*figure) {
    std::vector<double> values;
    for (const ClosureRecord& closure : run.closures) values.push_back(closure.*figure);
    return Median(std::move(values));
  };
  const auto row = [&](const std::string& name, const ClosureRecord& c) {
    table.Row({name, FixedText(1000 * c.coarse_m, 1, "closure"),
               FixedText(c.coarse_deg, 4, "closure"), FixedText(1000 * c.fine_m, 2, "closure"),
               FixedText(c.fine_deg, 4, "closure")});
  };
  row(fmt::format("median of {}", run.closures.size()), {{},
                                                         median(&ClosureRecord::coarse_m),
                                                         median(&ClosureRecord::coarse_deg),
                                                         median(&ClosureRecord::fine_m),
                                                         median(&ClosureRecord::fine_deg)});
  std::vector<ClosureRecord> worst = run.closures;
  std::stable_sort(worst.begin(), worst.end(),
                   [](const auto& a, const auto& b) { return a.fine_m > b.fine_m; });
  constexpr std::size_t kListed = 10;
  worst.resize(std::min(worst.size(), kListed));
  for (const ClosureRecord& c : worst) {
    row(HtmlText(c.stations[0] + " \xe2\x80\x93 " + c.stations[1] + " \xe2\x80\x93 " +
                 c.stations[2]),
        c);
  }
  return table.Finish() +
         HtmlSentence(
             "<span class=\"soft\">Of the pairs' own motions, before any adjustment. Along a "
             "direction in which links are weak, refined motions may close no better than coarse "
             "ones; the network gives it little weight where others hold it, and rests on it where "
             "nothing else does.</span>");
}

std::string HeldOutTable(const RunRecord& run) {
  HtmlTable table({{"station"},
                   {"station"},
                   {"planes", true},
                   {"rms before [mm]", true},
                   {"rms after [mm]", true},
                   {"mean before [mm]", true},
                   {"mean after [mm]", true}});
  bool any = false;
  for (const LinkRecord& link : run.links) {
    if (!link.held_out) continue;
    any = true;
    const HeldOutRecord& h = *link.held_out;
    const std::string field = "held-out planes of " + link.source + " and " + link.target;
    const auto mm = [&](double metres) { return FixedText(1000 * metres, 2, field); };
    table.Row({HtmlBold(link.source), HtmlBold(link.target), std::to_string(h.planes),
               mm(h.rms_before_m), mm(h.rms_after_m), mm(h.bias_before_m), mm(h.bias_after_m)});
  }
  return any ? table.Finish() : HtmlSentence("No planes were held out.");
}

std::string FigureTable(const RunRecord& run) {
  HtmlTable table({{"figure"}, {"value", true}});
  for (const auto& [name, value] : run.network) {
    FixedText(value, 0, "network figure " + name);
    table.Row({HtmlText(CodeWords(name)), fmt::format("{:.6g}", value)});
  }
  return table.Finish() +
         HtmlSentence(
             "<span class=\"soft\">Of all components together. Removed: motions that the "
             "adjustment did not use, of which a pair may have several; readmitted: used ones that "
             "contradicted the first spanning tree. Registered in full: attempts from features, of "
             "which a pair may have several, too. The &sigma; factor is 1 where the redundancy "
             "is 0, because then nothing tells; that of cycles is from before links were "
             "removed.</span>");
}

}  // namespace

std::string NetworkSection(const RunRecord& run) {
  if (run.network.empty()) return HtmlSentence("No network was adjusted.");
  std::string html;
  if (!run.components.empty()) html += ComponentTable(run);
  html += FigureTable(run);
  html += "<h3>Triangle closures</h3>\n" + ClosureTable(run);
  html += "<h3>Planes that took no part in the adjustment</h3>\n" + HeldOutTable(run);
  return html;
}

}  // namespace backsight
