#include "pipeline/moving_points.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "io/scan_reader.h"
#include "io/scene_file.h"
#include "pipeline/simulate_campaign.h"
#include "pipeline/survey_pipeline.h"
#include "stages/merging.h"
#include "stages/simulation/campaign.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCrossing = R"(schema_version: 1
name: crossing
seed: 99
format: las
ground: {size_m: 110, slope_deg: [0.8, -0.4], undulation_m: 0.1}
buildings:
  - {center_m: [-20, 16], size_m: [22, 12], storeys: 3, style: masonry}
  - {center_m: [16, 17], size_m: [24, 12], heading_deg: 4, style: modern, roof: flat}
  - {center_m: [-16, -17], size_m: [26, 12], heading_deg: 178, style: industrial, roof: hip}
  - {center_m: [19, -16], size_m: [18, 11], heading_deg: 184, style: masonry}
trees: [{position_m: [-3, 9]}, {position_m: [5, -8.5], height_m: 6}]
poles: [{position_m: [-9, -8]}, {position_m: [12, 8.5]}]
cars: [{position_m: [-14, 7.2]}, {position_m: [9, -7.4], heading_deg: 180}]
moving:
  people: 8
  area_m: [-26, -8, 26, 8]
  traffic: [{count: 2, from_m: [-40, -2], to_m: [40, -2]}, {count: 2, from_m: [40, 2], to_m: [-40, 2]}]
scanner: {step_deg: 0.3}
stations:
  - {id: A, position_m: [-18, -5]}
  - {id: B, position_m: [-6, 5]}
  - {id: C, position_m: [5, -4.8]}
  - {id: D, position_m: [17, 4.8]}
)";

/// The labels of a station's returns, in the order of its scan file.
std::vector<std::uint8_t> TrueLabels(const Campaign& campaign, std::size_t station) {
  const StationScan scan = SimulateStation(campaign, station, ExecutionContext(2));
  std::vector<std::uint8_t> labels;
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d point(scan.grid.x[i], scan.grid.y[i], scan.grid.z[i]);
    if (!point.isZero(0.0)) labels.push_back(scan.moving[i]);
  }
  return labels;
}

std::vector<std::uint8_t> ReadClasses(const std::string& path) {
  std::vector<std::uint8_t> classes;
  const auto reader = OpenScan(path);
  PointChunk chunk;
  while (reader->Next(chunk)) {
    classes.insert(classes.end(), chunk.classification.begin(), chunk.classification.end());
  }
  return classes;
}

/// From scan files to the classes of the merged cloud, which holds the stations one after another.
TEST(MovingPoints, PeopleAndCarsAreMarkedInTheMergedCloud) {
  const fs::path root = fs::path(::testing::TempDir()) / "moving_points";
  fs::remove_all(root);
  fs::create_directories(root / "out");
  std::ofstream(root / "scene.yaml") << kCrossing;
  SimulateCampaign((root / "scene.yaml").string(), root.string(), ExecutionContext(2));
  SurveyOptions options;
  SurveyProject project =
      ReadSurveyProject((root / "crossing.yaml").string(), OptionSections(options));
  project.outputs = {};
  const SurveyRun run =
      RunSurvey(project, options, nullptr, (root / "out").string(), ExecutionContext(2), {});
  ASSERT_EQ(run.record.exit_code, kComplete) << run.record.verdict;

  const Campaign campaign = PrepareCampaign(ReadScene((root / "scene.yaml").string()));
  const std::vector<std::uint8_t> classes = ReadClasses((root / "out/merged.las").string());
  double count[2][2] = {{0.0, 0.0}, {0.0, 0.0}};  // truly moving, marked
  std::size_t next = 0;
  for (std::size_t s = 0; s < campaign.stations.size(); ++s) {
    for (const std::uint8_t label : TrueLabels(campaign, s)) {
      ASSERT_LT(next, classes.size());
      count[label][classes[next++] == kMovingClass ? 1 : 0] += 1.0;
    }
  }
  ASSERT_EQ(next, classes.size());
  const double moving = count[1][0] + count[1][1];
  const double still = count[0][0] + count[0][1];
  fmt::print("crossing: {:.0f} points moved, {:.2f} % of them marked; {:.3f} % of {:.0f} others\n",
             moving, 100.0 * count[1][1] / moving, 100.0 * count[0][1] / still, still);
  EXPECT_GT(moving, 10000.0);
  EXPECT_GE(count[1][1], 0.9 * moving);
  EXPECT_LE(count[0][1], 0.005 * still);
  fs::remove_all(root);
}

}  // namespace
}  // namespace backsight
