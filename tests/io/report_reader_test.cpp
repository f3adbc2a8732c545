#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"
#include "io/report_document.h"
#include "io/report_html.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;

std::string Complaint(const std::string& text) {
  try {
    ParseReport(text, "out/report.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// What is said of the sample after `spoil` changed it.
std::string ComplaintOf(const std::function<void(ordered_json&)>& spoil) {
  ordered_json json = ordered_json::parse(ReportJson(SampleReport()));
  spoil(json);
  return Complaint(json.dump());
}

TEST(ReportReader, ReadsWhatWasWritten) {
  const std::string text = ReportJson(SampleReport());
  const ReportDocument document = ParseReport(text, "report.json");
  EXPECT_EQ(ReportHtml(document), ReportHtml(ParseReport(ReportJson(document), "again")));
  EXPECT_EQ(document.run.links.size(), SampleRun().links.size());
  EXPECT_EQ(document.run.links[0].rms_m, SampleRun().links[0].rms_m);
  EXPECT_FALSE(document.run.links[11].fine.has_value());
  EXPECT_EQ(document.run.poses[10].component, -1);
  EXPECT_EQ(document.run.poses[10].status, StationStatus::kNotRegistered);
  EXPECT_EQ(document.run.poses[2].covariance, SampleRun().poses[2].covariance);
  EXPECT_TRUE(document.run.georeference[0].points[2].check);
  EXPECT_EQ(document.pictures.size(), 4U);
}

TEST(ReportReader, CountsSkippedPairs) {
  RunRecord run = SampleRun();
  LinkRecord skipped;
  skipped.status = LinkStatus::kSkipped;
  skipped.reason = "not_similar";
  run.links.insert(run.links.begin(), 17, skipped);
  const ReportDocument document = ParseReport(ReportJson(MakeReportDocument(run, {})), "x");
  ASSERT_EQ(document.skipped_pairs.size(), 1U);
  EXPECT_EQ(document.skipped_pairs[0].second, 17U);
  EXPECT_EQ(document.run.links.size(), SampleRun().links.size());
}

TEST(ReportReader, DamageIsNamedWithItsPlace) {
  for (const auto& [spoil, complaint] :
       std::vector<std::pair<std::function<void(ordered_json&)>, std::string>>{
           {[](auto& j) { j.erase("verdict"); },
            "out/report.json: /: no key \"verdict\"; expected this key"},
           {[](auto& j) { j["schema_version"] = 1; },
            "out/report.json: /schema_version: 1; expected 4; write it anew"},
           {[](auto& j) { j["links"][0]["rms_m"] = "small"; },
            "/links/0/rms_m: \"small\"; expected a number"},
           {[](auto& j) { j["links"][0]["status"] = "fine"; },
            "/links/0/status: \"fine\"; expected one of accepted, doubtful, rejected"},
           {[](auto& j) { j["scans"][1]["points"] = -4; }, "/scans/1/points: -4; expected a whole"},
           {[](auto& j) { j["scans"][1]["points"] = 1.5; },
            "/scans/1/points: 1.5; expected a whole"},
           {[](auto& j) { j["poses"][0]["component"] = 1e12; }, "/poses/0/component"},
           {[](auto& j) { j["poses"][0]["covariance"].erase(5); },
            "/poses/0/covariance: 5 values; expected 6 values"},
           {[](auto& j) { j["poses"][0]["survey_from_station"]["quaternion_wxyz"][0] = 3.0; },
            "/poses/0/survey_from_station/quaternion_wxyz"},
           {[](auto& j) { j["gates"] = ordered_json::object(); }, "/gates: {}; expected a list"},
           {[](auto& j) { j["distances"] = 3; }, "/distances: 3; expected an object"},
           {[](auto& j) { j["georeference"][0]["points"][0]["role"] = "both"; },
            "role: \"both\"; expected check or control"},
           {[](auto& j) { j["pictures"][2]["png_base64"] = "\"><script>"; },
            "/pictures/2/png_base64: other characters; expected base64"},
           {[](auto& j) { j["pictures"][2]["width_px"] = 0; }, "/pictures/2/width_px"},
           {[](auto& j) { j["pictures"][2]["metres_per_pixel"] = 0; }, "metres_per_pixel"},
           {[](auto& j) { j["pictures"][2]["left_top"][0] = 1e19; }, "/pictures/2/left_top"},
           {[](auto& j) { j["distances"]["bin_m"] = 0; }, "/distances/bin_m"}}) {
    EXPECT_THAT(ComplaintOf(spoil), HasSubstr(complaint));
  }
}

TEST(ReportReader, BrokenTextIsNamedWithItsByte) {
  const std::string text = ReportJson(SampleReport());
  EXPECT_THAT(Complaint(text.substr(0, 1000)), HasSubstr("out/report.json: byte 1001: no JSON"));
  EXPECT_THAT(Complaint(""), HasSubstr("expected the report.json of a run; write it anew"));
  EXPECT_THAT(Complaint("[1]"), HasSubstr("expected an object"));
  EXPECT_THAT(Complaint("{\"schema_version\": 1e999}"), HasSubstr("numbers that a double holds"));
}

}  // namespace
}  // namespace backsight
