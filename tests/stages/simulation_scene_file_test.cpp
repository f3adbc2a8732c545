#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "io/scene_file.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SceneFile : public ::testing::Test {
 protected:
  std::string Write(const std::string& text) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) / (std::string(test->name()) + ".yaml");
    std::ofstream(path_) << text;
    return path_.string();
  }
  void TearDown() override {
    if (!path_.empty()) std::filesystem::remove(path_);
  }
  std::string ErrorOf(const std::string& text) {
    try {
      ReadScene(Write(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

 private:
  std::filesystem::path path_;
};

TEST_F(SceneFile, TheScenesOfTheProjectAreValid) {
  for (const char* path : {"projects/demo/scene.yaml", "tests/e2e/scenes/courtyard.yaml",
                           "tests/e2e/scenes/hall.yaml", "tests/benchmarks/factory_hall.yaml"}) {
    const Scene scene = ReadScene(path);
    EXPECT_GE(scene.stations.size(), 4U) << path;
    EXPECT_GE(scene.control.size(), 4U) << path;
  }
}

TEST_F(SceneFile, ReadsWhatIsWritten) {
  const Scene scene = ReadScene(Write(R"(schema_version: 1
seed: 99
format: ply
ground: {size_m: 80, slope_deg: [1, -2], kerbs: [{from_m: [0, 0], to_m: [5, 0]}]}
buildings: [{center_m: [1, 2], size_m: [20, 8], style: modern, roof: flat, repeat: true}]
rooms: [{center_m: [0, 0], size_m: [9, 7], pillar_spacing_m: 3}]
barriers: [{from_m: [0, 0], to_m: [0, 4], kind: fence}]
poles: [{position_m: [3, 4], lamp: false}]
trees: [{position_m: [5, 6], leaves: 10}]
cars: [{position_m: [7, 8], heading_deg: -45}]
moving: {people: 4, area_m: [-1, -2, 3, 4], traffic: [{count: 2, from_m: [0, 1], to_m: [5, 1]}]}
scanner: {step_deg: 0.5, orientation: random_so3, mixed_pixels: false}
stations: [{id: A1, position_m: [1, 1]}]
control: [{id: C1, position_m: [1, 2, 3], role: check, sigma_m: 0.004}]
)"));
  EXPECT_EQ(scene.name, "campaign");
  EXPECT_EQ(scene.seed, 99U);
  EXPECT_EQ(scene.format, CampaignFormat::kPly);
  EXPECT_EQ(scene.ground.slope_deg, Eigen::Vector2d(1, -2));
  EXPECT_EQ(scene.ground.kerbs.at(0).to_m, Eigen::Vector2d(5, 0));
  EXPECT_EQ(scene.buildings.at(0).style, FacadeStyle::kModern);
  EXPECT_EQ(scene.buildings.at(0).roof, RoofShape::kFlat);
  EXPECT_TRUE(scene.buildings.at(0).repeat);
  EXPECT_EQ(scene.rooms.at(0).pillar_spacing_m, 3.0);
  EXPECT_EQ(scene.barriers.at(0).kind, BarrierKind::kFence);
  EXPECT_FALSE(scene.poles.at(0).lamp);
  EXPECT_EQ(scene.trees.at(0).leaves, 10);
  EXPECT_EQ(scene.cars.at(0).heading_deg, -45.0);
  EXPECT_EQ(scene.people.count, 4);
  EXPECT_EQ(scene.people.max_m, Eigen::Vector2d(3, 4));
  ASSERT_EQ(scene.traffic.size(), 1U);
  EXPECT_EQ(scene.traffic[0].count, 2);
  EXPECT_EQ(scene.traffic[0].to_m, Eigen::Vector2d(5, 1));
  EXPECT_EQ(scene.scanner.orientation, Orientation::kRandomSo3);
  EXPECT_FALSE(scene.scanner.mixed_pixels);
  EXPECT_EQ(scene.stations.at(0).id, "A1");
  EXPECT_TRUE(scene.control.at(0).check);
  EXPECT_EQ(scene.control.at(0).sigma_m, 0.004);
}

TEST_F(SceneFile, NamesAllMistakesAtOnceWithTheirLines) {
  const std::string error = ErrorOf(R"(schema_version: 1
seed: many
bulidings: []
buildings:
  - {center_m: [0, 10], size_m: [12, 10], storeys: 0}
  - {center_m: [0], size_m: [12, 10], rof: gable}
scanner:
  step_deg: 0.5
  orientation: sideways
  max_range_m: 0.1
  min_range_m: 5
stations:
  - {id: S1, position_m: [0, 0]}
  - {id: S1, position_m: [500, 0]}
  - {id: a/b, position_m: [0, 0]}
)");
  for (const char* place : {".yaml:2", ".yaml:3", ".yaml:5", ".yaml:6", ".yaml:9", ".yaml:10",
                            ".yaml:14", ".yaml:15"}) {
    EXPECT_THAT(error, HasSubstr(place));
  }
  EXPECT_THAT(error, HasSubstr("buildings"));
  EXPECT_THAT(error, HasSubstr("roof"));
  EXPECT_THAT(error, HasSubstr("random_heading"));
}

TEST_F(SceneFile, ReadsTheCoreOfARoomAndRefusesOneThatFillsIt) {
  const std::string scene =
      "schema_version: 1\nformat: las\nstations: [{id: S1, position_m: [0, 0]}]\n"
      "rooms: [{center_m: [0, 0], size_m: [30, 20], repeat: true, core_m: [24, ";
  const Scene read = ReadScene(Write(scene + "14]}]\n"));
  EXPECT_EQ(read.rooms.at(0).core_m, Eigen::Vector2d(24.0, 14.0));
  EXPECT_TRUE(read.rooms.at(0).repeat);
  EXPECT_EQ(read.format, CampaignFormat::kLas);
  EXPECT_THAT(ErrorOf(scene + "19]}]\n"), HasSubstr("core_m"));
}

TEST_F(SceneFile, RefusesACrsThatControlCannotBeGivenIn) {
  const auto error = [&](const std::string& crs) {
    return ErrorOf("schema_version: 1\nstations: [{id: S1, position_m: [0, 0]}]\ncrs: {" + crs +
                   "}\n");
  };
  EXPECT_EQ(error("horizontal: EPSG:25832, origin: [690000, 5336000, 520]"), "");
  EXPECT_THAT(error("horizontal: EPSG:25832, vertical: EPSG:25832, origin: [690000, 5336000, 520]"),
              AllOf(HasSubstr(".yaml:3: crs: found EPSG:25832"), HasSubstr("not vertical")));
  EXPECT_THAT(error("horizontal: EPSG:99999, origin: [690000, 5336000, 520]"),
              HasSubstr(".yaml:3: crs: found EPSG:99999"));
  EXPECT_THAT(error("horizontal: EPSG:25832, origin: [5336000, 690000, 520]"),
              HasSubstr("easting and northing swapped?"));
}

TEST_F(SceneFile, NeedsStations) {
  EXPECT_THAT(ErrorOf("schema_version: 1\n"), HasSubstr("stations"));
  EXPECT_THAT(ErrorOf("schema_version: 1\nstations: []\n"), HasSubstr("stations"));
}

TEST_F(SceneFile, RefusesAnEmptyAreaAndAPointForALine) {
  const std::string error = ErrorOf(R"(schema_version: 1
moving: {people: 2, area_m: [1, 1, 0, 5], traffic: [{count: 1, from_m: [0, 1], to_m: [0, 1]}]}
barriers: [{from_m: [1, 1], to_m: [1, 1]}]
stations: [{id: S1, position_m: [0, 0]}]
)");
  EXPECT_THAT(error, HasSubstr(".yaml:2"));
  EXPECT_THAT(error, HasSubstr("moving.traffic[0].to_m"));
  EXPECT_THAT(error, HasSubstr(".yaml:3"));
}

}  // namespace
}  // namespace backsight
