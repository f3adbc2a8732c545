#include "pipeline/simulate_campaign.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "io/geodetic_frame.h"
#include "io/las_check.h"
#include "io/scan_reader.h"
#include "io/scene_file.h"
#include "io/survey_project.h"
#include "stages/simulation/campaign.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kScene = R"(schema_version: 1
name: tiny
buildings: [{center_m: [0, 9], size_m: [14, 8], wall_height_m: 6, storeys: 2}]
moving: {people: 2, area_m: [-6, -6, 6, 3]}
scanner: {step_deg: 2}
stations:
  - {id: S1, position_m: [-4, 0]}
  - {id: S2, position_m: [4, -1]}
control: [{id: P1, position_m: [0, 1, 1.5]}, {id: C1, position_m: [1, -4, 1.5], role: check}]
)";

std::string Slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class SimulateCampaignTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(::testing::TempDir()) / (std::string("simulate_") + test->name());
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  std::string WriteScene(const std::string& text) {
    std::ofstream(root_ / "scene.yaml") << text;
    return (root_ / "scene.yaml").string();
  }

  fs::path root_;
};

TEST_F(SimulateCampaignTest, WritesACampaignThatTheReadersAccept) {
  const std::string scene_path = WriteScene(kScene);
  SimulateCampaign(scene_path, (root_ / "out").string(), ExecutionContext(2));
  const SurveyProject project = ReadSurveyProject((root_ / "out/tiny.yaml").string(), {});
  ASSERT_EQ(project.stations.size(), 2U);
  EXPECT_TRUE(project.stations[0].levelled);

  const Campaign campaign = PrepareCampaign(ReadScene(scene_path));
  const StationScan scan = SimulateStation(campaign, 1, ExecutionContext(1));
  const auto reader = OpenScan(project.stations[1].scan);
  EXPECT_EQ(reader->info().rows, scan.rows);
  EXPECT_EQ(reader->info().columns, scan.columns);
  PointChunk chunk;
  std::uint64_t points = 0;
  while (reader->Next(chunk)) points += chunk.size();
  EXPECT_EQ(points, scan.returns);
}

TEST_F(SimulateCampaignTest, TruthIsWrittenToTwelveDigits) {
  const std::string scene_path = WriteScene(kScene);
  SimulateCampaign(scene_path, (root_ / "out").string(), ExecutionContext(1));
  std::istringstream truth(Slurp(root_ / "out/truth.csv"));
  std::string line;
  std::getline(truth, line);
  EXPECT_EQ(line, "station,component,status,tx_m,ty_m,tz_m,qw,qx,qy,qz");
  std::getline(truth, line);
  EXPECT_THAT(line, HasSubstr("S1,0,registered,0.000000000000,"));
  std::getline(truth, line);
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream fields(line);
  std::string id;
  std::string component;
  std::string status;
  Eigen::Vector3d t;
  fields >> id >> component >> status >> t.x() >> t.y() >> t.z();
  const Campaign campaign = PrepareCampaign(ReadScene(scene_path));
  EXPECT_LT((t - campaign.stations[1].survey_from_station.translation).norm(), 1e-11);
  EXPECT_THAT(Slurp(root_ / "out/control.csv"), HasSubstr("P1,control,S1,"));
}

TEST_F(SimulateCampaignTest, TargetsAreControlOfTheProject) {
  SimulateCampaign(WriteScene(kScene), (root_ / "out").string(), ExecutionContext(1));
  const SurveyProject project = ReadSurveyProject((root_ / "out/tiny.yaml").string(), {});
  EXPECT_FALSE(project.crs);
  ASSERT_EQ(project.control.size(), 2U);
  EXPECT_EQ(project.control[0].role, ControlPoint::Role::kControl);
  EXPECT_EQ(project.control[1].role, ControlPoint::Role::kCheck);
  EXPECT_EQ(project.control[0].measured.size(), 2U);
  EXPECT_LT((project.control[0].crs_m.head<2>() - Eigen::Vector2d(0.0, 1.0)).norm(), 0.02);
}

TEST_F(SimulateCampaignTest, TargetsAreInTheScenesCrs) {
  const std::string scene =
      std::string(kScene) +
      "crs: {horizontal: EPSG:25832, origin: [690000, 5336000, 520], heading_deg: 90}\n";
  SimulateCampaign(WriteScene(scene), (root_ / "out").string(), ExecutionContext(1));
  const SurveyProject project = ReadSurveyProject((root_ / "out/tiny.yaml").string(), {});
  ASSERT_TRUE(project.crs);
  EXPECT_EQ(project.crs->horizontal, "EPSG:25832");
  GeodeticFrame frame("EPSG:25832", "", "");
  frame.SetOrigin({690000.0, 5336000.0, 520.0});
  // The world's y axis looks west.
  const Eigen::Vector3d enu = frame.EnuFromCrs(project.control[0].crs_m);
  EXPECT_LT((enu.head<2>() - Eigen::Vector2d(-1.0, 0.0)).norm(), 0.02);
}

TEST_F(SimulateCampaignTest, SameBytesForAnyThreads) {
  const std::string scene_path = WriteScene(kScene);
  SimulateCampaign(scene_path, (root_ / "one").string(), ExecutionContext(1));
  SimulateCampaign(scene_path, (root_ / "four").string(), ExecutionContext(4));
  for (const char* name :
       {"scans/S1.ptx", "scans/S2.ptx", "truth.csv", "control.csv", "tiny.yaml"}) {
    const std::string one = Slurp(root_ / "one" / name);
    EXPECT_FALSE(one.empty()) << name;
    EXPECT_TRUE(one == Slurp(root_ / "four" / name)) << name;
  }
}

TEST_F(SimulateCampaignTest, WritesPlyWhereAsked) {
  SimulateCampaign(WriteScene(std::string(kScene) + "format: ply\n"), (root_ / "out").string(),
                   ExecutionContext(1));
  const auto reader = OpenScan((root_ / "out/scans/S1.ply").string());
  EXPECT_EQ(reader->info().format, "PLY");
  EXPECT_TRUE(reader->info().has_rgb);
}

TEST_F(SimulateCampaignTest, WritesLasWhereAsked) {
  const std::string scene_path = WriteScene(std::string(kScene) + "format: las\n");
  SimulateCampaign(scene_path, (root_ / "out").string(), ExecutionContext(1));
  EXPECT_THAT(Slurp(root_ / "out/tiny.yaml"), HasSubstr("scan: scans/S1.las"));
  EXPECT_NO_THROW(ReadSurveyProject((root_ / "out/tiny.yaml").string(), {}));

  const std::string path = (root_ / "out/scans/S2.las").string();
  const LasHeader header = VerifyLas(path);
  const StationScan scan =
      SimulateStation(PrepareCampaign(ReadScene(scene_path)), 1, ExecutionContext(1));
  EXPECT_EQ(header.points, scan.returns);
  EXPECT_EQ(header.point_format, 7);
  EXPECT_DOUBLE_EQ(header.scale.x(), 0.0001);
  // The scanner's frame: the instrument stands at the origin, within the bounds.
  EXPECT_TRUE((header.min.array() < 0.0).all());
  EXPECT_TRUE((header.max.array() > 0.0).all());
  const auto reader = OpenScan(path);
  EXPECT_EQ(reader->info().format, "LAS 1.4");
  EXPECT_EQ(reader->info().point_count, scan.returns);
  EXPECT_TRUE(reader->info().has_rgb);
}

TEST_F(SimulateCampaignTest, RefusesAnUnwritablePlace) {
  const std::string scene_path = WriteScene(kScene);
  EXPECT_THROW(SimulateCampaign(scene_path, scene_path + "/out", ExecutionContext(1)), InputError);
}

}  // namespace
}  // namespace backsight
