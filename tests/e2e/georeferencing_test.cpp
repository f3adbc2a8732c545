#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/random.h"
#include "io/scan_reader.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// The yard in a CRS, with 12 control and 20 check points of 2 mm about it.
std::string SurveyedYard() {
  std::string scene = ReadBytes("tests/e2e/scenes/yard.yaml");
  scene.replace(scene.find("format: ptx"), 11, "format: ply");
  scene.erase(scene.find("\ncontrol:"));
  scene += "\ncrs: {horizontal: EPSG:25832, origin: [690000, 5336000, 520], heading_deg: 33}\n";
  scene += "control:\n";
  Random random(25832);
  for (int k = 0; k < 32; ++k) {
    const double x = random.Uniform(-12.0, 15.0);
    const double y = random.Uniform(-17.0, 8.0);
    scene += fmt::format("  - {{id: P{}, position_m: [{:.3f}, {:.3f}, {:.3f}], role: {}}}\n", k + 1,
                         x, y, random.Uniform(0.4, 3.0), k < 12 ? "control" : "check");
  }
  return scene;
}

class Georeferenced : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    WriteBytes(*folder_ / "scene.yaml", SurveyedYard());
    const ProgramRun run =
        RunProgram(fmt::format("simulate '{}' '{}'", *folder_ / "scene.yaml", *folder_ / "yard"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string Project() { return ReadBytes(*folder_ / "yard/yard.yaml"); }
  static std::string WithoutOutputs(std::string project) {
    const std::size_t start = project.find("  merged:");
    return project.replace(start, project.find('\n', start) - start, "  merged: []");
  }

  /// Runs the text as a project and returns its report.
  static json Run(const std::string& name, const std::string& project, int exit_code) {
    const std::string path = *folder_ / ("yard/" + name + ".yaml");
    WriteBytes(path, project);
    const std::string out = *folder_ / name;
    const ProgramRun run = RunProgram(fmt::format("run '{}' --out '{}' --quiet", path, out));
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    return json::parse(ReadBytes(out + "/report.json"));
  }

  static std::unique_ptr<ScratchFolder> folder_;
};

std::unique_ptr<ScratchFolder> Georeferenced::folder_;

/// The line of a point in a project file.
std::size_t FindPoint(const std::string& project, const std::string& id) {
  return project.find("  - {id: " + id + ",");
}

TEST_F(Georeferenced, CheckPointsErrNoMoreThanPredicted) {
  const json report = Run("survey", Project(), 0);
  const json& ground = report["georeference"][0];
  EXPECT_EQ(ground["status"], "georeferenced");
  const json& check = ground["check"];
  EXPECT_EQ(check["points"], 20);
  const double rmse = check["rmse_3d_m"];
  const double predicted = check["predicted_3d_m"];
  EXPECT_LT(rmse, 1.3 * predicted);
  EXPECT_LT(predicted, 0.006);
  fmt::print("check points: n = 20, RMSE 3D {:.2f} mm, predicted {:.2f} mm\n", 1000.0 * rmse,
             1000.0 * predicted);

  const auto merged = OpenScan(*folder_ / "yard/out/merged.las");
  EXPECT_THAT(merged->info().crs, HasSubstr("\"EPSG\",\"25832\""));
  PointChunk chunk;
  ASSERT_TRUE(merged->Next(chunk));
  EXPECT_NEAR(chunk.x[0], 690000.0, 120.0);
  EXPECT_NEAR(chunk.y[0], 5336000.0, 120.0);
  EXPECT_NEAR(chunk.z[0], 520.0, 60.0);
}

TEST_F(Georeferenced, AMovedControlPointIsNamedAndLeavesNoTrace) {
  const std::string project = WithoutOutputs(Project());
  std::string moved = project;
  const std::size_t easting = moved.find("crs: [", FindPoint(moved, "P5")) + 6;
  const std::size_t comma = moved.find(',', easting);
  const double value = std::stod(moved.substr(easting, comma - easting)) + 0.05;
  moved.replace(easting, comma - easting, fmt::format("{:.9f}", value));
  const json with = Run("moved", moved, 0);
  EXPECT_THAT(with["warnings"].dump(), HasSubstr("control point P5 is off by (-"));

  std::string removed = project;
  const std::size_t begin = FindPoint(removed, "P5");
  removed.erase(begin, FindPoint(removed, "P6") - begin);
  const json without = Run("removed", removed, 0);
  ASSERT_EQ(with["poses"].size(), without["poses"].size());
  for (std::size_t s = 0; s < with["poses"].size(); ++s) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = [&](const json& report) -> double {
        return report["poses"][s]["ground"]["crs_position"][axis];
      };
      EXPECT_NEAR(at(with), at(without), 1e-3);
    }
  }
}

TEST_F(Georeferenced, ControlThatCannotPlaceAnythingIsRefusedBeforeTheRun) {
  std::string project = Project();
  project.erase(FindPoint(project, "P3"));
  WriteBytes(*folder_ / "yard/two.yaml", project);
  for (const char* command : {"check", "run"}) {
    const ProgramRun run = RunProgram(fmt::format("{} '{}'", command, *folder_ / "yard/two.yaml"));
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_THAT(run.err, HasSubstr("2 points with role control"));
  }
  // A check point that cannot be converted would otherwise be found out after the registration.
  project = Project();
  const std::size_t easting = project.find("crs: [", FindPoint(project, "P20")) + 6;
  project.replace(easting, project.find(',', easting) - easting, "99000000");
  WriteBytes(*folder_ / "yard/nowhere.yaml", project);
  const ProgramRun run = RunProgram(fmt::format("check '{}'", *folder_ / "yard/nowhere.yaml"));
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_THAT(run.err, HasSubstr("P20"));
}

}  // namespace
}  // namespace backsight
