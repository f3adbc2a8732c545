#include "io/report_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/report_plan.h"

namespace backsight {

std::string GateTable(const RunRecord& run) {
  if (run.gates.empty()) return HtmlSentence("The project file sets no quality gates.");
  HtmlTable table({{"gate"}, {"limit", true}, {"value", true}, {"result"}});
  for (const GateRecord& gate : run.gates) {
    table.Row({HtmlText(gate.name), HtmlText(gate.limit), HtmlText(gate.value),
               HtmlMark(gate.passed, gate.passed ? "passed" : "failed")});
  }
  return table.Finish();
}

std::string StationTable(const RunRecord& run) {
  HtmlTable table({{"station"},
                   {"status"},
                   {"component", true},
                   {"x [m]", true},
                   {"y [m]", true},
                   {"z [m]", true},
                   {"&sigma; position, worst [mm]", true},
                   {"&sigma; rotation, worst [deg]", true},
                   {"links", true},
                   {"reason"}});
  for (const PoseRecord& pose : run.poses) {
    const bool placed = pose.status == StationStatus::kRegistered;
    std::vector<std::string> cells = {
        HtmlBold(pose.station),
        HtmlMark(placed, CodeWords(ToString(pose.status))),
    };
    if (placed) {
      const std::string field = "position of station " + pose.station;
      cells.push_back(std::to_string(ComponentNumber(pose.component)));
      for (int i = 0; i < 3; ++i) {
        cells.push_back(FixedText(pose.survey_from_station.translation(i), 3, field));
      }
    } else {
      cells.insert(cells.end(), 4, "");
    }
    const std::optional<PoseSigma> sigma = placed ? SigmaOf(pose) : std::nullopt;
    cells.push_back(sigma ? FixedText(1000 * sigma->worst_position_m, 2, "sigma") : "");
    cells.push_back(sigma ? FixedText(sigma->rotation_deg.maxCoeff(), 4, "sigma") : "");
    cells.push_back(std::to_string(pose.link_count));
    cells.push_back(HtmlText(CodeWords(pose.reason)));
    table.Row(cells, placed ? "" : "off");
  }
  return table.Finish();
}

/// A sentence that counts the pairs never tried, by reason; links.csv lists them.
std::string SkippedSentence(const RunRecord& run) {
  std::map<std::string, std::size_t> reasons;
  std::size_t skipped = 0;
  for (const LinkRecord& link : run.links) {
    if (link.status != LinkStatus::kSkipped) continue;
    ++reasons[link.reason];
    ++skipped;
  }
  if (skipped == 0) return {};
  std::string list;
  for (const auto& [reason, count] : reasons) {
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", GroupedText(count),
                        HtmlText(CodeWords(reason)));
  }
  return fmt::format("<p>{} more pairs were skipped: {}. links.csv lists them.</p>\n",
                     GroupedText(skipped), list);
}

std::string LinkTable(const RunRecord& run) {
  const bool tried = std::any_of(run.links.begin(), run.links.end(), [](const LinkRecord& link) {
    return link.status != LinkStatus::kSkipped;
  });
  if (!tried) return HtmlSentence("No pair was tried.") + SkippedSentence(run);
  HtmlTable table({{"source"},
                   {"target"},
                   {"status"},
                   {"reason"},
                   {"overlap [%]", true},
                   {"rms [mm]", true},
                   {"weakest &sigma; [mm]", true},
                   {"consensus", true},
                   {"by chance", true},
                   {"planes", true},
                   {"network residual [mm]", true},
                   {"[deg]", true},
                   {"weight", true},
                   {"loop"}});
  for (const LinkRecord& link : run.links) {
    if (link.status == LinkStatus::kSkipped) continue;
    const std::string field = "link " + link.source + " " + link.target;
    const bool accepted = link.status == LinkStatus::kAccepted;
    const auto fine = [&](double value, int decimals) {
      return link.fine ? FixedText(value, decimals, field) : std::string();
    };
    const auto network = [&](double value, int decimals) {
      return accepted ? fine(value, decimals) : std::string();
    };
    const bool aligned = link.fine.has_value() || link.coarse.has_value();
    const std::string loop = !accepted || !link.loop_controlled ? std::string()
                             : *link.loop_controlled            ? std::string("yes")
                                                                : HtmlMark(false, "uncontrolled");
    std::string residual = network(1000 * link.network_residual_m, 1);
    if (!residual.empty()) {
      residual = fmt::format("<i class=\"key r{}\"></i>{}", ResidualClass(link.network_residual_m),
                             residual);
    }
    table.Row(
        {HtmlBold(link.source), HtmlBold(link.target), HtmlMark(accepted, ToString(link.status)),
         HtmlText(CodeWords(link.reason)), aligned ? FixedText(100 * link.overlap, 0, field) : "",
         fine(1000 * link.rms_m, 2), fine(1000 * link.weakest_sigma_m, 2),
         std::to_string(link.consensus), std::to_string(link.consensus_null),
         link.fine ? std::to_string(link.planes) : "", residual,
         network(link.network_residual_deg, 4), network(link.network_weight, 2), loop},
        accepted ? "" : "off");
  }
  return table.Finish() + SkippedSentence(run);
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
                   {"extent [m]", true},
                   {"repairs and notes"}});
  for (const ScanRecord& scan : run.scans) {
    std::string notes;
    for (const std::string& note : scan.notes) {
      notes += (notes.empty() ? "" : "<br>") + HtmlText(note);
    }
    table.Row({HtmlBold(scan.station), "<code>" + HtmlText(scan.path) + "</code>",
               HtmlText(scan.format), GroupedText(scan.records), GroupedText(scan.points),
               GroupedText(scan.dropped), GroupedText(scan.moving), GroupedText(scan.leaves),
               GroupedText(scan.keypoints),
               FixedText(scan.extent_m, 1, "extent_m of " + scan.station), notes});
  }
  return table.Finish();
}

std::string OutputTable(const RunRecord& run) {
  if (run.outputs.empty()) return HtmlSentence("Nothing was written.");
  HtmlTable table({{"file"}, {"format"}, {"points", true}});
  for (const OutputRecord& output : run.outputs) {
    table.Row({"<code>" + HtmlText(output.path) + "</code>", HtmlText(output.format),
               output.points ? GroupedText(*output.points) : ""});
  }
  return table.Finish();
}

}  // namespace backsight
