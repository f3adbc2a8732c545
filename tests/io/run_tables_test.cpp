#include "io/run_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/error.h"
#include "io/csv_table.h"
#include "io/report_document.h"
#include "io/run_json.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string InternalComplaint(const std::function<void()>& function) {
  try {
    function();
  } catch (const InternalError& e) {
    return e.what();
  }
  return {};
}

std::string ReportText(const RunRecord& run) { return ReportJson(MakeReportDocument(run, {})); }

TEST(RunTables, HeadersAreFixed) {
  EXPECT_EQ(PosesCsv({}),
            "station,component,status,tx_m,ty_m,tz_m,qw,qx,qy,qz,reason,links,sigma_x_m,sigma_y_m,"
            "sigma_z_m,sigma_worst_m,sigma_rx_deg,sigma_ry_deg,sigma_rz_deg,enu_tx_m,enu_ty_m,"
            "enu_tz_m,enu_qw,enu_qx,enu_qy,enu_qz,crs_easting,crs_northing,crs_height,"
            "sigma_east_m,sigma_north_m,sigma_up_m\n");
  EXPECT_EQ(LinksCsv({}),
            "source,target,status,reason,tx_m,ty_m,tz_m,qw,qx,qy,qz,coarse_tx_m,coarse_ty_m,"
            "coarse_tz_m,coarse_qw,coarse_qx,coarse_qy,coarse_qz,overlap,rms_m,fine_status,"
            "correspondences,consensus,consensus_null,planes,weakest_sigma_m,iterations,"
            "network_weight,network_residual_m,network_residual_deg,loop_controlled,candidates,"
            "conflict,agreement,sigma_worst_m,sigma_worst_deg,held_out_planes,"
            "held_out_rms_before_m,held_out_rms_after_m,held_out_bias_before_m,"
            "held_out_bias_after_m,network_residual_sigmas,worst_place_sigma_m,worst_place_x,"
            "worst_place_y,worst_place_z,predicted\n");
}

TEST(RunTables, LinksReadBackExactly) {
  const auto links = SampleRun().links;
  const CsvTable table = CsvTable::Parse(LinksCsv(links), "links.csv");
  ASSERT_EQ(table.rows().size(), links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const LinkRecord& link = links[i];
    const CsvTable::Row& row = table.rows()[i];
    EXPECT_EQ(table.Text(row, "source"), link.source);
    EXPECT_EQ(table.Text(row, "target"), link.target);
    EXPECT_EQ(table.Text(row, "status"), ToString(link.status));
    EXPECT_EQ(table.Text(row, "reason"), link.reason);
    EXPECT_EQ(table.Integer(row, "correspondences"), link.correspondences);
    EXPECT_EQ(table.Text(row, "qw").empty(), !link.fine.has_value());
    EXPECT_EQ(table.Text(row, "coarse_qw").empty(), !link.coarse.has_value());
    if (!link.fine) continue;
    EXPECT_EQ(table.Real(row, "tx_m"), link.fine->translation.x());
    EXPECT_EQ(table.Real(row, "coarse_tz_m"), link.coarse->translation.z());
    EXPECT_EQ(table.Real(row, "qz"), link.fine->Quaternion().z());
    EXPECT_EQ(table.Real(row, "rms_m"), link.rms_m);
    EXPECT_EQ(table.Real(row, "network_residual_deg"), link.network_residual_deg);
    EXPECT_EQ(table.Real(row, "network_residual_sigmas"), link.network_residual_sigmas);
    EXPECT_EQ(table.Real(row, "worst_place_sigma_m"), link.worst_place->sigma_m);
    EXPECT_EQ(table.Real(row, "worst_place_z"), link.worst_place->direction.z());
    EXPECT_EQ(table.Text(row, "predicted"), link.predicted ? "true" : "false");
    EXPECT_EQ(table.Text(row, "loop_controlled"), *link.loop_controlled ? "true" : "false");
    EXPECT_EQ(table.Real(row, "conflict"), link.conflict);
    EXPECT_EQ(table.Text(row, "held_out_planes").empty(), !link.held_out.has_value());
    EXPECT_EQ(table.Text(row, "sigma_worst_m").empty(), !link.covariance.has_value());
    if (!link.held_out) continue;
    EXPECT_EQ(table.Real(row, "held_out_rms_after_m"), link.held_out->rms_after_m);
    EXPECT_EQ(table.Real(row, "held_out_bias_before_m"), link.held_out->bias_before_m);
  }
}

TEST(RunTables, SkippedPairsHaveAReasonAndNoFigures) {
  RunRecord run = SampleRun();
  LinkRecord skipped;
  skipped.source = "S12", skipped.target = "S1";
  skipped.status = LinkStatus::kSkipped;
  skipped.reason = "not_similar";
  const std::size_t tried = run.links.size();
  run.links.push_back(skipped);
  const CsvTable table = CsvTable::Parse(LinksCsv(run.links), "links.csv");
  const CsvTable::Row& row = table.rows().back();
  EXPECT_EQ(table.Text(row, "status"), "skipped");
  EXPECT_EQ(table.Text(row, "reason"), "not_similar");
  for (const char* column : {"tx_m", "coarse_qw", "overlap", "consensus", "correspondences"}) {
    EXPECT_EQ(table.Text(row, column), "") << column;
  }
  const auto json = nlohmann::ordered_json::parse(ReportText(run));
  EXPECT_EQ(json["links"].size(), tried);
  EXPECT_EQ(json["skipped_pairs"]["not_similar"], 1);
}

TEST(RunTables, SigmasAreThoseOfTheStationsPosition) {
  PoseRecord pose;
  pose.status = StationStatus::kRegistered;
  pose.survey_from_station.translation = {100.0, 0.0, 0.0};
  Matrix6d covariance = Matrix6d::Zero();
  covariance(2, 2) = 1e-8;  // 0.1 mrad about z turns a station 100 m off by 10 mm in y
  pose.covariance = covariance;
  const PoseSigma sigma = *SigmaOf(pose);
  EXPECT_NEAR(sigma.position_m.x(), 0.0, 1e-12);
  EXPECT_NEAR(sigma.position_m.y(), 0.01, 1e-12);
  EXPECT_NEAR(sigma.worst_position_m, 0.01, 1e-12);
  EXPECT_NEAR(sigma.rotation_deg.z(), 1e-4 * 180.0 / std::numbers::pi, 1e-12);
  // Uncertain rotation about the station itself leaves its position alone.
  Vector6d about_station;
  about_station << 0.0, 0.0, 1.0, 0.0, -100.0, 0.0;
  pose.covariance = 1e-8 * about_station * about_station.transpose();
  EXPECT_NEAR(SigmaOf(pose)->worst_position_m, 0.0, 1e-9);
}

TEST(RunTables, NotANumberIsRefusedByName) {
  RunRecord run = SampleRun();
  run.poses[1].survey_from_station.translation.y() = kNaN;
  EXPECT_THAT(InternalComplaint([&] { PosesCsv(run.poses); }),
              HasSubstr("poses.csv, station S2, ty_m is nan"));
  EXPECT_THAT(InternalComplaint([&] { PosesJson(run.poses); }),
              HasSubstr("poses.json/poses/1/survey_from_station/translation_m/1 is nan"));
  run.links[0].rms_m = std::numeric_limits<double>::infinity();
  EXPECT_THAT(InternalComplaint([&] { LinksCsv(run.links); }),
              HasSubstr("links.csv, link S1 S2, rms_m is inf"));
  ManifestRecord manifest;
  manifest.wall_s = kNaN;
  EXPECT_THAT(InternalComplaint([&] { ManifestJson(manifest); }),
              HasSubstr("manifest.json/wall_s"));
  run.poses[0].covariance = Matrix6d::Constant(kNaN);
  EXPECT_THAT(InternalComplaint([&] { PosesCsv(run.poses); }), HasSubstr("station S1"));
}

TEST(RunJson, ParsesBackWithStableKeys) {
  const RunRecord run = SampleRun();
  const std::string text = ReportText(run);
  EXPECT_EQ(text, ReportText(run));
  EXPECT_THAT(text, StartsWith("{\n  \"schema_version\": 4,\n"));
  const auto json = nlohmann::ordered_json::parse(text);
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"schema_version", "project_name", "version", "verdict",
                                            "exit_code", "gates", "network", "components",
                                            "closures", "survey_points", "georeference", "poses",
                                            "links", "skipped_pairs", "scans", "outputs",
                                            "warnings", "distances", "pictures"}));
  EXPECT_EQ(json["links"].size(), run.links.size());
  EXPECT_EQ(json["links"][0]["rms_m"], *run.links[0].rms_m);
  EXPECT_TRUE(json["links"][8]["network_residual_m"].is_null());
  EXPECT_TRUE(json["links"][11]["target_from_source"].is_null());
  EXPECT_EQ(json["poses"][2]["covariance"][5][5], (*run.poses[2].covariance)(5, 5));
  EXPECT_TRUE(json["poses"][10]["survey_from_station"].is_null());
  EXPECT_EQ(json["network"]["sigma_factor"], 1.3);
  EXPECT_EQ(json["components"][0]["weakest_station"], "S5");
  EXPECT_EQ(json["closures"][0]["stations"][2], "S8");
  EXPECT_EQ(json["links"][0]["covariance"][3][3], (*run.links[0].covariance)(3, 3));
  EXPECT_EQ(json["links"][0]["held_out"]["planes"], run.links[0].held_out->planes);
  EXPECT_TRUE(json["links"][8]["held_out"].is_null());
  EXPECT_EQ(json["gates"][0]["passed"], false);
  const auto& ground = json["georeference"][0];
  EXPECT_EQ(ground["points"][1]["excluded"], true);
  EXPECT_EQ(ground["points"][2]["role"], "check");
  EXPECT_TRUE(ground["points"][2]["w"].is_null());
  EXPECT_EQ(ground["check"]["rmse_3d_m"], run.georeference[0].check.rmse_3d_m);
  EXPECT_EQ(json["poses"][1]["ground"]["crs_position"][0], run.poses[1].ground->position.x());
  EXPECT_TRUE(json["poses"][10]["ground"].is_null());
  const auto poses = nlohmann::ordered_json::parse(PosesJson(run.poses));
  EXPECT_EQ(poses["poses"], json["poses"]);
}

TEST(RunJson, AScaleThatWasNotTestedIsNull) {
  RunRecord run = SampleRun();
  const auto ground = [&run] {
    return nlohmann::ordered_json::parse(ReportText(run))["georeference"][0];
  };
  EXPECT_EQ(ground()["scale_test"]["sigma_ppm"], 30.5);
  run.georeference[0].scale_test.reset();
  EXPECT_TRUE(ground()["scale_test"].is_null());
}

TEST(RunJson, ManifestHoldsOptionsInputsAndTimes) {
  ManifestRecord manifest;
  manifest.version = "0.1.0";
  manifest.project_path = "bad \xff byte";
  manifest.options = "registration.resolution_m=0.1\n";
  manifest.inputs = {{"scans/S1.ptx", "00ff"}};
  manifest.stages = {{"ingest", 1.5, 2.4, 0.2}};
  manifest.clouds = {{"out/merged.las", 1234567890123}};
  const auto json = nlohmann::ordered_json::parse(ManifestJson(manifest));
  EXPECT_EQ(json["schema_version"], 1);
  EXPECT_EQ(json["inputs"][0]["fingerprint"], "00ff");
  EXPECT_EQ(json["stages"][0]["seconds"], 1.5);
  EXPECT_EQ(json["stages"][0]["processor_s"], 2.4);
  EXPECT_EQ(json["stages"][0]["idle_share"], 0.2);
  EXPECT_EQ(json["options"], manifest.options);
  EXPECT_EQ(json["clouds"][0]["bytes"], 1234567890123);
}

TEST(RunJson, ReadsTheCloudsOfAManifest) {
  const std::string path = ::testing::TempDir() + "/backsight_manifest.json";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return ReadWrittenClouds(path);
  };
  ManifestRecord manifest;
  manifest.clouds = {{"out/merged.las", 1234567890123, -42}, {"out/a.e57", 7, 1}};
  const std::vector<WrittenCloud> clouds = read(ManifestJson(manifest));
  ASSERT_EQ(clouds.size(), 2U);
  EXPECT_EQ(clouds[0].path, "out/merged.las");
  EXPECT_EQ(clouds[0].bytes, 1234567890123U);
  EXPECT_EQ(clouds[0].modified, -42);
  for (const char* damaged :
       {"", "{", "[]", "{\"clouds\": 3}", "{\"clouds\": [1, {\"path\": 2, \"bytes\": 3}]}",
        "{\"clouds\": [{\"path\": \"a\", \"bytes\": -3, \"modified\": 1}]}",
        "{\"clouds\": [{\"path\": \"a\", \"bytes\": 3}]}", "{\"version\": \"\xff\"}"}) {
    EXPECT_TRUE(read(damaged).empty()) << damaged;
  }
  std::filesystem::remove(path);
  EXPECT_TRUE(ReadWrittenClouds(path).empty());
}

TEST(EllipseOf, PointsWhereThePlaceIsLeastCertain) {
  // 3 mm towards azimuth 30 degrees, 1 mm across, and more in height, which plays no part.
  const double azimuth = std::numbers::pi / 6.0;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() << std::sin(azimuth), std::cos(azimuth), std::cos(azimuth),
      -std::sin(azimuth);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.bottomRightCorner<3, 3>() =
      axes * Eigen::Vector3d(9e-6, 1e-6, 1e-4).asDiagonal() * axes.transpose();
  const ErrorEllipse ellipse = EllipseOf({}, covariance);
  EXPECT_NEAR(ellipse.semi_major_m, 0.003, 1e-9);
  EXPECT_NEAR(ellipse.semi_minor_m, 0.001, 1e-9);
  EXPECT_NEAR(ellipse.azimuth_deg, 30.0, 1e-6);

  // What turns about the origin by 0.1 mrad moves a place 10 m east of it by 1 mm, north or south.
  Matrix6d turning = Matrix6d::Zero();
  turning(2, 2) = 1e-8;
  const ErrorEllipse swung = EllipseOf({Eigen::Matrix3d::Identity(), {10.0, 0.0, 2.0}}, turning);
  EXPECT_NEAR(swung.semi_major_m, 0.001, 1e-9);
  EXPECT_NEAR(swung.semi_minor_m, 0.0, 1e-9);
  EXPECT_NEAR(std::remainder(swung.azimuth_deg, 180.0), 0.0, 1e-6);
}

}  // namespace
}  // namespace backsight
