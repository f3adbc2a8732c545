#include "io/report_html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <string_view>

#include "core/error.h"
#include "io/html_text.h"
#include "io/report_plan.h"
#include "io/run_tables.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::size_t Count(const std::string& text, std::string_view part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

std::string Html(const RunRecord& run) { return ReportHtml(MakeReportDocument(run, {})); }

TEST(ReportHtml, ShowsVerdictStationsAndLinks) {
  const RunRecord run = SampleRun();
  const std::string html = ReportHtml(SampleReport());
  EXPECT_THAT(html, StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(html, HasSubstr(HtmlText(run.verdict)));
  EXPECT_THAT(html, HasSubstr("<b>8 + 2 of 12</b>"));
  for (const PoseRecord& pose : run.poses) {
    EXPECT_THAT(html, HasSubstr("<td><b>" + pose.station + "</b></td>"));
  }
  for (const LinkRecord& link : run.links) {
    EXPECT_THAT(html, HasSubstr("<b>" + link.source + "</b> \xe2\x80\x93 <b>" + link.target +
                                "</b></span></td>"));
  }
  EXPECT_THAT(html, HasSubstr("under what was rejected: <b>S11</b>, <b>S12</b>.<"));
  EXPECT_EQ(Count(html, "<circle class=\"station\""), 10U);
  EXPECT_EQ(Count(html, "class=\"link accepted"), 9U);
  EXPECT_EQ(Count(html, "<path class=\"noloop\""), 3U);  // one, and two legends'
  EXPECT_EQ(Count(html, "class=\"link rejected\" x1=\"2\""), 2U);
  for (const char* absent : {"<script", "http:", "https:", "nan", "inf\""}) {
    EXPECT_THAT(html, Not(HasSubstr(absent)));
  }
  EXPECT_EQ(html, ReportHtml(SampleReport()));
  // For people who want to look at it.
  if (const char* path = std::getenv("BACKSIGHT_KEEP_REPORT")) std::ofstream(path) << html;
}

TEST(ReportHtml, SaysFirstWhatMattersMost) {
  const std::string html = ReportHtml(SampleReport());
  std::size_t last = 0;
  for (const char* part :
       {"<h1>Town hall facade", "Backsight 0.1.0", "ETRS89 / UTM zone 32N", "class=\"verdict",
        "stations registered", "quality gate", "<h2>Warnings", "<h2>Network in plan", "<h2>Links",
        "<h2>Stations", "<h2>Control and check points", "<h2>The registered cloud", "Picture: plan",
        "Picture: detail", "Picture: distances", "Histogram of distances", "<h2>Scans",
        "<h2>What was rejected"}) {
    const std::size_t at = html.find(part, last);
    EXPECT_NE(at, std::string::npos) << part;
    if (at != std::string::npos) last = at;
  }
}

TEST(ReportHtml, CountsThePartsOfANetwork) {
  RunRecord run = SampleRun();
  for (PoseRecord& pose : run.poses) {
    if (pose.status != StationStatus::kRegistered) continue;
    pose.component = 0;
    pose.ground.reset();
  }
  EXPECT_THAT(Html(run), HasSubstr("<b>10 of 12</b><span>stations registered</span>"));
  EXPECT_THAT(Html(run), ::testing::ContainsRegex("worst formal &sigma; of a position: S[0-9]+, "
                                                  "relative to S1<"));
  EXPECT_THAT(Html(run), Not(HasSubstr("in component 2, which no link joins")));
  run.poses[7].component = run.poses[8].component = 1;
  EXPECT_THAT(Html(run), HasSubstr("<b>8 + 2 of 12</b><span>stations registered, in 2 components"));
  EXPECT_THAT(Html(run), HasSubstr("in component 2, which no link joins with the main network"));
  ReportDocument drawn = SampleReport();
  drawn.run = run;
  EXPECT_THAT(ReportHtml(drawn), HasSubstr("show component 1 alone, without the 2 stations of"));
  (*run.poses[8].covariance) *= 1e6;
  EXPECT_THAT(Html(run), HasSubstr("of a position: " + run.poses[8].station + ", relative to " +
                                   run.poses[7].station + "<"));
}

TEST(ReportHtml, MarksPredictedLinksAndSaysHowFarTheWorstIsOff) {
  RunRecord run = SampleRun();
  for (LinkRecord& link : run.links) link.predicted = false;
  EXPECT_THAT(Html(run), Not(HasSubstr(">predicted<")));
  LinkRecord& link = run.links[1];
  ASSERT_EQ(link.status, LinkStatus::kAccepted);
  link.predicted = true;
  link.network_residual_m = 0.4321;
  link.network_residual_sigmas = 7.84;
  const std::string html = Html(run);
  EXPECT_EQ(Count(html, ">predicted<"), 1U);
  run.links.back().status = LinkStatus::kRejected;
  run.links.back().predicted = true;
  EXPECT_EQ(Count(Html(run), ">predicted<"), 2U);
  EXPECT_THAT(html, HasSubstr("<b>432.1 mm</b><span>worst network residual: " + link.source +
                              " \xe2\x80\x93 " + link.target + ", 7.8 of its &sigma;</span>"));
}

TEST(ReportHtml, DistancesOfAFewPlacesAreNoFigureOfALink) {
  RunRecord run = SampleRun();
  const LinkRecord& link = run.links[0];
  ASSERT_EQ(link.status, LinkStatus::kAccepted);
  PairDistanceRecord pair{{link.target, link.source}, {50, 0.1234, 0.2, 0.3456}};
  run.distances->pairs = {pair};
  const auto figures = HasSubstr("<td class=\"n\">123.4</td><td class=\"n\">345.6</td>");
  EXPECT_THAT(Html(run), figures);
  run.distances->pairs[0].figures.samples = 49;
  EXPECT_THAT(Html(run), Not(figures));
}

TEST(ReportHtml, NamesTheFrameOfCoordinates) {
  RunRecord run = SampleRun();
  EXPECT_THAT(Html(run),
              HasSubstr("<b>ETRS89 / UTM zone 32N</b>; heights: <b>ellipsoidal heights"));
  run.georeference[0].origin_deg_deg_m.reset();
  run.georeference[0].crs = "local grid of the control";
  EXPECT_THAT(Html(run), HasSubstr("<b>local grid of the control</b> in metres"));
  // A small component on the ground does not put the main network there.
  GeoreferenceRecord second = run.georeference[0];
  second.component = 1;
  run.georeference[0].status = "too_few_points";
  run.georeference.push_back(second);
  EXPECT_THAT(Html(run), HasSubstr("Coordinates: <b>survey frame</b>"));
  EXPECT_THAT(Html(run), HasSubstr("control ties component 2 to <b>local grid of the control"));
  std::swap(run.georeference[0].status, run.georeference[1].status);
  EXPECT_THAT(Html(run), HasSubstr("<b>Not so component 2</b>"));
  run.georeference.clear();
  EXPECT_THAT(Html(run), HasSubstr("<b>survey frame</b>"));
}

TEST(ReportHtml, ExplainsTheReasonsThatOccur) {
  RunRecord run = SampleRun();
  const auto other = [&](LinkStatus status, const char* reason) {
    LinkRecord link;
    link.source = run.poses[0].station;
    link.target = run.poses[1].station;
    link.status = status;
    link.reason = reason;
    run.links.push_back(link);
  };
  other(LinkStatus::kRejected, "tilted");
  other(LinkStatus::kDoubtful, "ambiguous");
  other(LinkStatus::kSkipped, "redundant");
  other(LinkStatus::kFailed, "out of memory");
  const std::string html = Html(run);
  EXPECT_THAT(html, HasSubstr("<td>tilted</td><td>both are levelled, and their vertical axes"));
  EXPECT_THAT(html, HasSubstr("<td>ambiguous</td><td>several placements fit alike"));
  EXPECT_THAT(html, HasSubstr("<td>redundant</td><td>would overlap, but"));
  EXPECT_THAT(html, Not(HasSubstr("the project file excludes it")));
  EXPECT_THAT(html, HasSubstr("<td>out of memory</td>"));  // no code, but said
  EXPECT_THAT(html, Not(HasSubstr("<tr><td>out of memory</td>")));
}

TEST(ReportHtml, DrawsHowWellItIsDetermined) {
  const std::string html = ReportHtml(SampleReport());
  EXPECT_EQ(Count(html, "<ellipse class=\"sigma\" rx="), 10U);
  EXPECT_THAT(html, ::testing::ContainsRegex("are drawn <b>[0-9]+ times</b> too large"));
  EXPECT_GE(Count(html, "in its worst direction"), 9U);
  EXPECT_THAT(html, HasSubstr("median 1.10 mm"));
  EXPECT_THAT(html, HasSubstr("68 % 1.70 mm"));
  EXPECT_THAT(html, HasSubstr("95 % 4.20 mm"));
  EXPECT_EQ(Count(html, "<rect class=\"bar\""), 40U);
}

TEST(ReportHtml, FramesPictures) {
  const std::string html = ReportHtml(SampleReport());
  EXPECT_EQ(Count(html, "href=\"data:image/png;base64,iVBORw0KGgo"), 4U);
  EXPECT_EQ(Count(html, "<figcaption>A gradient."), 4U);
  EXPECT_EQ(Count(html, ">height [m]</text>"), 4U);
  EXPECT_EQ(Count(html, "<line class=\"cut\""), 4U);
  EXPECT_THAT(html, HasSubstr("background:#0072b2\"></i>S1"));
  EXPECT_THAT(html, HasSubstr(">5 m</text>"));
  EXPECT_THAT(html, HasSubstr(">E [m]</text>"));
}

TEST(ReportHtml, ShowsControlAndCheckPoints) {
  RunRecord run = SampleRun();
  std::string html = Html(run);
  for (const char* part : {"ETRS89 / UTM zone 32N", "ellipsoidal heights", "<td>P1</td>",
                           "residuals drawn <b>", "blunder, excluded", "<td>C1</td>", "3D 2.3 mm",
                           "n = 1, not ASPRS-conformant", "12.5 &plusmn; 30.5 ppm"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  run.georeference[0].scale_test.reset();
  html = Html(run);
  EXPECT_THAT(html, HasSubstr("Scale against control: not tested"));
  EXPECT_THAT(html, Not(HasSubstr("&plusmn; 0.0 ppm")));
  run.georeference[0].status = "too_few_points";
  html = Html(run);
  EXPECT_THAT(html, HasSubstr("Not tied to the ground: too few points"));
  EXPECT_THAT(html, Not(HasSubstr("<td>P1</td>")));
  run.georeference.clear();
  EXPECT_THAT(Html(run), HasSubstr("The project gives 3, but there is no network"));
  run.survey_points = 0;
  EXPECT_THAT(Html(run), HasSubstr("The project gives neither"));
}

TEST(ReportHtml, ControlThatNothingChecksIsNotCalledGood) {
  RunRecord run = SampleRun();
  EXPECT_THAT(Html(run), Not(HasSubstr("unchecked: N")));
  SurveyPointRecord& point = run.georeference[0].points[0];
  *point.w = {0.5, 0.0, -0.7};
  point.checked = {true, false, true};
  EXPECT_THAT(Html(run),
              HasSubstr("<td class=\"n\">0.70<span class=\"bad\">\xe2\x9c\x97 unchecked: N"));
  point.checked = {false, false, false};
  EXPECT_THAT(Html(run),
              HasSubstr("<td class=\"n\"><span class=\"bad\">\xe2\x9c\x97 unchecked: ENH"));
}

TEST(ReportHtml, CountsComponentsFromOne) {
  RunRecord run = SampleRun();
  GeoreferenceRecord second = run.georeference[0];
  second.component = 1;
  run.georeference.push_back(second);
  run.poses[0].component = 812;
  run.components[0].component = 913;
  const std::string html = Html(run);
  for (const char* part : {"<h3>Component 1</h3>", "<h3>Component 2</h3>", "<h3>Component 813: 1 s",
                           ">813</td>", ">914</td>", "Plan view of component 1\""}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  EXPECT_THAT(html, Not(HasSubstr("omponent 0")));
  EXPECT_THAT(PosesCsv(run.poses), HasSubstr("S1,812,registered"));
}

TEST(ReportHtml, SaysWhichPointsACloudHolds) {
  const std::string html = Html(SampleRun());
  const auto row = [&](const std::string& file) {
    const std::size_t begin = html.find("<code>" + file);
    return html.substr(begin, html.find("</tr>", begin) - begin);
  };
  EXPECT_THAT(row("out/merged.las"), HasSubstr(">the best per cell of 5 mm<"));
  EXPECT_THAT(row("out/stations/S1.e57"), HasSubstr(">all<"));
  EXPECT_THAT(row("out/map.ot"), Not(HasSubstr("all")));
}

TEST(ReportHtml, CountsSkippedPairsByReason) {
  RunRecord run = SampleRun();
  LinkRecord skipped;
  skipped.source = "S12", skipped.target = "S1";
  skipped.status = LinkStatus::kSkipped;
  skipped.reason = "not_similar";
  run.links.insert(run.links.end(), 1234, skipped);
  const std::string html = Html(run);
  EXPECT_THAT(html, HasSubstr("1\xc2\xa0"
                              "234 more pairs were skipped"));
  EXPECT_THAT(html, HasSubstr("not similar"));
  EXPECT_THAT(html, Not(HasSubstr("<b>S12</b> \xe2\x80\x93 <b>S1</b>")));
  EXPECT_THAT(html, HasSubstr("<b>9 of 12</b>"));
}

TEST(ReportHtml, EscapesEverything) {
  const std::string evil = "<script>alert(\"1\")</script>'&\x01\xff";
  RunRecord run = SampleRun();
  for (auto& link : run.links) {
    if (link.source == "S1") link.source = evil;
    link.reason = evil;
  }
  run.poses[0].station = evil;
  for (auto& pose : run.poses) pose.reason = evil;
  run.project_name = run.version = run.verdict = evil;
  for (auto& scan : run.scans) scan.station = scan.path = scan.format = evil;
  run.scans[0].notes = {evil};
  run.outputs[0].path = run.outputs[0].format = run.outputs[0].selection = evil;
  run.gates[0].name = run.gates[0].limit = run.gates[0].value = evil;
  run.warnings = {evil};
  GeoreferenceRecord& ground = run.georeference[0];
  ground.crs = ground.heights = evil;
  for (auto& point : ground.points) point.id = evil;
  run.network = {{evil, 1.0}};
  run.components[0].refinement = run.components[0].weakest_station = evil;
  run.closures[0].stations[1] = evil;
  PictureRecord picture;
  picture.title = picture.caption = picture.across = picture.up = picture.png_base64 = evil;
  picture.width_px = picture.height_px = 100;
  picture.metres_per_pixel = 0.1;
  picture.keys = {{evil, {}}};
  picture.scale = PictureScale{evil, {{0.0, {}}, {1.0, {}}}};
  picture.lines = {{evil, {0.0, 0.0}, {1.0, 1.0}}};
  run.distances->pairs[0].stations[0] = evil;
  const std::string html = ReportHtml(MakeReportDocument(run, {picture}));
  for (const char* raw : {"<script", "alert(\"", "\x01", "\xff"}) {
    EXPECT_THAT(html, Not(HasSubstr(raw)));
  }
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&#39;&amp;"));
}

TEST(ReportHtml, StandsEmptyRunsAndLoneStations) {
  EXPECT_THAT(Html({}), HasSubstr("No station is registered."));
  RunRecord run = SampleRun();
  run.poses.resize(1);
  EXPECT_THAT(Html(run), HasSubstr("S1 stands alone."));
  run = SampleRun();
  for (auto& pose : run.poses) pose.survey_from_station.translation.setZero();
  EXPECT_THAT(Html(run), HasSubstr("<svg class=\"plan\""));
}

TEST(ReportHtml, NotANumberIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& spoil : std::vector<std::function<void(RunRecord&)>>{
           [&](RunRecord& r) { r.poses[8].survey_from_station.translation.x() = nan; },
           [&](RunRecord& r) { r.poses[8].survey_from_station.translation.z() = nan; },
           [&](RunRecord& r) { (*r.poses[8].covariance)(0, 0) = nan; },
           [&](RunRecord& r) { r.links[1].network_residual_m = nan; },
           [&](RunRecord& r) { r.links[1].network_residual_sigmas = nan; },
           [&](RunRecord& r) { r.links[1].weakest_sigma_m = nan; },
           [&](RunRecord& r) { r.links[1].rms_m = nan; },
           [&](RunRecord& r) { r.links[0].held_out->rms_after_m = nan; },
           [&](RunRecord& r) { r.components[0].weakest_sigma_m = nan; },
           [&](RunRecord& r) { r.closures[0].fine_deg = nan; },
           [&](RunRecord& r) { r.scans[1].extent_m = nan; },
           [&](RunRecord& r) { r.distances->total.p95_m = nan; },
           [&](RunRecord& r) { r.georeference[0].points[0].residual_m.x() = nan; },
           [&](RunRecord& r) { r.network[0].second = nan; }}) {
    RunRecord run = SampleRun();
    spoil(run);
    EXPECT_THROW(Html(run), InternalError);
  }
}

TEST(ReportPlan, ClassesOfResiduals) {
  EXPECT_EQ(ResidualClass(0.0), 0);
  EXPECT_EQ(ResidualClass(0.002), 0);
  EXPECT_EQ(ResidualClass(0.004), 1);
  EXPECT_EQ(ResidualClass(0.009), 2);
  EXPECT_EQ(ResidualClass(5.0), 3);
}

}  // namespace
}  // namespace backsight
