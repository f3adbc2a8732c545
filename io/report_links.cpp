#include "io/report_links.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "io/html_table.h"
#include "io/html_text.h"
#include "io/link_reasons.h"
#include "io/report_plan.h"

namespace backsight {
namespace {

/// In one line unless it is long.
std::string PairName(const std::string& a, const std::string& b) {
  constexpr std::size_t kLong = 24;
  const std::string name = HtmlBold(a) + " \xe2\x80\x93 " + HtmlBold(b);
  return a.size() + b.size() > kLong ? name : "<span class=\"pair\">" + name + "</span>";
}

std::string FieldOf(const LinkRecord& link) { return "link " + link.source + " " + link.target; }

/// Distances between surfaces by the names of two stations, in either order.
std::map<std::pair<std::string, std::string>, DistanceFigures> DistancesByPair(
    const RunRecord& run) {
  std::map<std::pair<std::string, std::string>, DistanceFigures> figures;
  if (!run.distances) return figures;
  for (const PairDistanceRecord& pair : run.distances->pairs) {
    figures[{pair.stations[0], pair.stations[1]}] = pair.figures;
    figures[{pair.stations[1], pair.stations[0]}] = pair.figures;
  }
  return figures;
}

/// "az 45, el 12": where a direction points, in the frame of the plan; it has no sense.
std::string DirectionText(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double elevation = std::asin(std::clamp(d.z(), -1.0, 1.0)) * kDegrees;
  constexpr double kUpright = 80.0;
  if (elevation > kUpright) return "vertical";
  double azimuth = std::atan2(d.x(), d.y()) * kDegrees;
  if (azimuth < 0.0) azimuth += 360.0;
  return fmt::format("{}&deg; / {}&deg;", FixedText(azimuth, 0, "azimuth"),
                     FixedText(elevation, 0, "elevation"));
}

/// Key points that agree on the motion, if these proposed it.
std::string ConsensusText(const LinkRecord& link) {
  return link.predicted ? "predicted" : std::to_string(link.consensus);
}

std::string LoopMark(const LinkRecord& link) {
  if (!link.loop_controlled) return {};
  return *link.loop_controlled ? "yes" : HtmlMark(false, "uncontrolled");
}

bool AnyAccepted(const RunRecord& run) {
  return std::any_of(run.links.begin(), run.links.end(),
                     [](const LinkRecord& l) { return l.status == LinkStatus::kAccepted; });
}

/// What the reasons of pairs mean, of those that occur.
std::string ReasonTable(const ReportDocument& document) {
  std::set<std::string> reasons;
  for (const LinkRecord& link : document.run.links) {
    if (link.status != LinkStatus::kAccepted) reasons.insert(link.reason);
  }
  for (const auto& [reason, count] : document.skipped_pairs) reasons.insert(reason);
  HtmlTable table({{"reason"}, {"means"}});
  bool any = false;
  for (const std::string& reason : reasons) {
    const std::string meaning(MeaningOfReason(reason));
    if (meaning.empty()) continue;
    any = true;
    table.Row({HtmlText(CodeWords(reason)), HtmlText(meaning)});
  }
  return any ? table.Finish() : std::string();
}

/// A sentence that counts the pairs never tried, by reason; links.csv lists them.
std::string SkippedSentence(const ReportDocument& document) {
  std::uint64_t skipped = 0;
  std::string list;
  for (const auto& [reason, count] : document.skipped_pairs) {
    skipped += count;
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", GroupedText(count),
                        HtmlText(CodeWords(reason)));
  }
  if (skipped == 0) return {};
  return HtmlSentence(fmt::format("{} more pairs were skipped: {}. links.csv lists them.",
                                  GroupedText(skipped), list));
}

/// Stations that have no place, or one apart from the main network.
std::string StationsApart(const RunRecord& run) {
  HtmlTable table({{"station"}, {"status"}, {"reason"}});
  bool any = false;
  for (const PoseRecord& pose : run.poses) {
    const bool placed = pose.status == StationStatus::kRegistered;
    if (placed && pose.component == 0) continue;
    any = true;
    table.Row({HtmlBold(pose.station),
               HtmlMark(false, placed ? "apart" : CodeWords(ToString(pose.status))),
               placed ? fmt::format("in component {}, which no link joins with the main network",
                                    ComponentNumber(pose.component))
                      : HtmlText(CodeWords(pose.reason))});
  }
  return any ? table.Finish() : HtmlSentence("All stations are registered, in one network.");
}

std::string RejectedPairs(const RunRecord& run) {
  HtmlTable table({{"pair"},
                   {"status"},
                   {"reason"},
                   {"overlap [%]", true},
                   {"seen through [%]", true},
                   {"consensus", true},
                   {"by chance", true}});
  bool any = false;
  for (const LinkRecord& link : run.links) {
    if (link.status == LinkStatus::kAccepted) continue;
    any = true;
    const bool aligned = link.fine.has_value() || link.coarse.has_value();
    const auto percent = [&](double share) {
      return aligned ? FixedText(100 * share, 0, FieldOf(link)) : std::string();
    };
    table.Row({PairName(link.source, link.target), HtmlMark(false, ToString(link.status)),
               HtmlText(CodeWords(link.reason)), percent(link.overlap), percent(link.conflict),
               ConsensusText(link), std::to_string(link.consensus_null)});
  }
  return any ? table.Finish() : HtmlSentence("No pair that was tried was rejected.");
}

std::string RejectedPoints(const RunRecord& run) {
  std::uint64_t records = 0, dropped = 0, points = 0, moving = 0;
  for (const ScanRecord& scan : run.scans) {
    records += scan.records;
    dropped += scan.dropped;
    points += scan.points;
    moving += scan.moving;
  }
  std::string html = HtmlSentence(fmt::format(
      "{} of {} records of the scans hold no usable point and were dropped; {} of {} points belong "
      "to things that were gone when other stations looked. The table of scans has them by "
      "station.",
      GroupedText(dropped), GroupedText(records), GroupedText(moving), GroupedText(points)));
  std::string blunders;
  for (const GeoreferenceRecord& g : run.georeference) {
    for (const SurveyPointRecord& p : g.points) {
      if (p.excluded) blunders += (blunders.empty() ? "" : ", ") + HtmlText(p.id);
    }
  }
  if (!blunders.empty()) {
    html += HtmlSentence("Control points left out as blunders: " + blunders + ".");
  }
  return html;
}

constexpr const char* kLinkNotes =
    "<span class=\"soft\">RMS: root mean square distance of points of both stations from the "
    "pair's common planes as its planar adjustment left them; what one station has of one plane "
    "counts as 50 points at most, and the planes of cells that are not quite flat count too. It "
    "tells pairs from each other; errors show in the surfaces. Empty: no planes. Surfaces: "
    "distances between both stations' surfaces where they finally stand (defined below, with "
    "their number); empty: fewer than 50 could be compared. Place, worst &sigma;: formal "
    "standard deviation of the source scanner's place in the direction in which the pair alone "
    "determines it least, and that direction; of the pair alone and without the systematic "
    "floor, so that errors of several times this &sigma; occur; azimuth from the plan's upward "
    "axis, clockwise. Network residual: how far the source stands apart, by the link and by the "
    "adjusted network; in its &sigma;: all six unknowns, by the pair's own standard deviations "
    "(systematic floor and links' &sigma; factor included), root mean square; up to about 1 is "
    "usual; above 2 the pair knows less than it says, or something is wrong there. 0 where no "
    "loop controls the link and no planes were adjusted.</span>";

}  // namespace

std::string LinkTable(const RunRecord& run) {
  if (!AnyAccepted(run)) return HtmlSentence("No link was accepted.");
  std::map<std::string, const PoseRecord*> poses;
  for (const PoseRecord& pose : run.poses) poses[pose.station] = &pose;
  const auto distances = DistancesByPair(run);
  HtmlTable table({{"link"},
                   {"over&shy;lap [%]", true},
                   {"RMS [mm]", true},
                   {"surfaces: median [mm]", true},
                   {"95 % [mm]", true},
                   {"place: worst &sigma; [mm]", true},
                   {"in direction: azimuth / elevation"},
                   {"network residual [mm]", true},
                   {"[deg]", true},
                   {"[its &sigma;]", true},
                   {"loop control"}});
  for (const LinkRecord& link : run.links) {
    if (link.status != LinkStatus::kAccepted) continue;
    const std::string field = FieldOf(link);
    const auto target = poses.find(link.target);
    const auto distance = distances.find({link.source, link.target});
    const auto mm = [&](const std::optional<double>& metres, int decimals) {
      return metres ? FixedText(1000 * *metres, decimals, field) : std::string();
    };
    const DistanceFigures figures =
        distance != distances.end() ? distance->second : DistanceFigures();
    const bool compared = figures.samples >= DistanceFigures::kFewest;
    const bool directed = link.worst_place && target != poses.end();
    table.Row(
        {PairName(link.source, link.target), FixedText(100 * link.overlap, 0, field),
         mm(link.rms_m, 2), compared ? mm(figures.median_m, 1) : "",
         compared ? mm(figures.p95_m, 1) : "",
         link.worst_place ? mm(link.worst_place->sigma_m, 2) : "",
         directed ? DirectionText(ShownPose(*target->second).rotation * link.worst_place->direction)
                  : "",
         link.network_residual_m
             ? fmt::format("<i class=\"key r{}\"></i>{}", ResidualClass(*link.network_residual_m),
                           mm(link.network_residual_m, 1))
             : "",
         link.network_residual_deg ? FixedText(*link.network_residual_deg, 4, field) : "",
         link.network_residual_sigmas ? FixedText(*link.network_residual_sigmas, 1, field) : "",
         LoopMark(link)});
  }
  return table.Finish() + HtmlSentence(kLinkNotes);
}

std::string LinkOriginTable(const RunRecord& run) {
  if (!AnyAccepted(run)) return {};
  HtmlTable table({{"link"},
                   {"correspon&shy;dences", true},
                   {"consensus", true},
                   {"by chance", true},
                   {"motions compared", true},
                   {"seen through [%]", true},
                   {"agree&shy;ment", true},
                   {"planes", true},
                   {"weakest &sigma; [mm]", true},
                   {"iterations", true},
                   {"weight", true},
                   {"ended as"}});
  for (const LinkRecord& link : run.links) {
    if (link.status != LinkStatus::kAccepted) continue;
    const std::string field = FieldOf(link);
    table.Row({PairName(link.source, link.target), std::to_string(link.correspondences),
               ConsensusText(link), std::to_string(link.consensus_null),
               std::to_string(link.candidates), FixedText(100 * link.conflict, 1, field),
               FixedText(link.agreement, 2, field), std::to_string(link.planes),
               link.weakest_sigma_m ? FixedText(1000 * *link.weakest_sigma_m, 2, field) : "",
               std::to_string(link.iterations),
               link.network_weight ? FixedText(*link.network_weight, 2, field) : "",
               HtmlText(CodeWords(link.fine_status))});
  }
  return "<h3>How the links were found</h3>\n" + table.Finish() +
         HtmlSentence(
             "<span class=\"soft\">Weakest &sigma;: formal standard deviation of the motion "
             "that the pair alone determines least, turns counted by the shift that they cause "
             "at its planes; above 5 mm it ends as weak, 100 m: nothing holds it. Pairs that "
             "clouds or the network prove need no consensus; predicted: by the network, or by a "
             "symmetry that other pairs have shown, after what key points had proposed, whose "
             "number and chance stand beside it.</span>");
}

std::string RejectedSection(const ReportDocument& document) {
  return "<h3>Stations</h3>\n" + StationsApart(document.run) + "<h3>Pairs</h3>\n" +
         RejectedPairs(document.run) + SkippedSentence(document) + ReasonTable(document) +
         "<h3>Points</h3>\n" + RejectedPoints(document.run);
}

}  // namespace backsight
