#include "io/survey_project.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "core/random.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct FakeOptions {
  double resolution_m = 0.1;

  std::vector<OptionSection> Sections() {
    return {{"registration", "Registration.", [this](OptionVisitor& v) {
               v.Real("resolution_m", resolution_m, "m", 0.01, 1.0, "Voxel edge");
             }}};
  }
};

class SurveyProjectTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              fmt::format("backsight_project_{}_{}", getpid(),
                          ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_ / "scans");
    for (const char* name : {"S1.ptx", "S2.ptx", "S3.ptx"}) {
      std::ofstream(folder_ / "scans" / name) << "scan";
    }
    std::ofstream(folder_ / "scans/S2.txt") << "1 2 3 4\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  SurveyProject Read(const std::string& text) {
    std::ofstream(folder_ / "survey.yaml", std::ios::binary) << text;
    return ReadSurveyProject((folder_ / "survey.yaml").string(), options_.Sections());
  }
  std::string Complaint(const std::string& text) {
    try {
      Read(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }

  std::filesystem::path folder_;
  FakeOptions options_;
};

constexpr char kWhole[] = R"(schema_version: 1
name: Town hall facade
crs: {horizontal: EPSG:25832, vertical: EPSG:7837}
stations:
  - {id: S1, scan: scans/S1.ptx}
  - {id: S2, scan: scans/S2.ptx, levelled: true, level_sigma_deg: 0.02}
  - {id: S3, scan: scans/S2.ptx, scan_index: 2, scanner_origin_m: [1, 2, 3]}
  - id: S4
    scan: ${BACKSIGHT_TEST_SCANS}/S3.ptx
    prior: {survey_from_station: [0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1], sigma_m: 0.5, sigma_deg: 5}
control:
  - id: P1
    crs: [691023.412, 5335821.223, 512.034]
    sigma_m: [0.003, 0.003, 0.005]
    role: check
    measured: [{station: S1, xyz: [1.234, 5.678, 0.910]}]
pairs: {include: [[S1, S2]], exclude: [[S3, S4]]}
registration: {resolution_m: 0.2}
outputs:
  merged: [{format: las, path: out/merged.las, thin_m: 0.005, max_points: 500000000}]
  stations: {format: e57, path: out/registered/}
gates: {max_station_sigma_mm: 5, max_check_rmse_mm: 10, require_all_stations: true}
resources: {threads: 2, memory_gb: 4}
)";

TEST_F(SurveyProjectTest, ReadsAWholeProject) {
  setenv("BACKSIGHT_TEST_SCANS", (folder_ / "scans").c_str(), 1);
  const SurveyProject project = Read(kWhole);
  EXPECT_EQ(project.name, "Town hall facade");
  ASSERT_EQ(project.stations.size(), 4U);
  EXPECT_EQ(project.stations[0].scan, (folder_ / "scans/S1.ptx").string());
  EXPECT_FALSE(project.stations[0].levelled);
  EXPECT_TRUE(project.stations[1].levelled);
  EXPECT_EQ(project.stations[1].level_sigma_deg, 0.02);
  EXPECT_EQ(project.stations[2].scan_index, 2);
  EXPECT_EQ(*project.stations[2].scanner_origin_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(project.stations[3].scan, (folder_ / "scans/S3.ptx").string());
  const RigidTransform& prior = project.stations[3].prior->survey_from_station;
  EXPECT_LT((prior * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(5, 7, 7)).norm(), 1e-12);
  EXPECT_EQ(project.crs->vertical, "EPSG:7837");
  ASSERT_EQ(project.control.size(), 1U);
  EXPECT_EQ(project.control[0].role, ControlPoint::Role::kCheck);
  EXPECT_EQ(project.control[0].crs_m.x(), 691023.412);
  EXPECT_EQ(project.control[0].measured[0].xyz_m.y(), 5.678);
  EXPECT_EQ(project.pairs.include[0].second, "S2");
  EXPECT_EQ(project.pairs.exclude[0].first, "S3");
  EXPECT_EQ(options_.resolution_m, 0.2);
  EXPECT_EQ(project.outputs.merged->at(0).path, (folder_ / "out/merged.las").string());
  EXPECT_EQ(project.outputs.merged->at(0).thin_m, 0.005);
  EXPECT_EQ(project.outputs.merged->at(0).max_points, 500'000'000);
  EXPECT_EQ(project.outputs.stations->format, CloudFormat::kE57);
  EXPECT_EQ(*project.gates.max_station_sigma_mm, 5.0);
  EXPECT_TRUE(project.gates.require_all_stations);
  EXPECT_EQ(project.resources.threads, 2);
  EXPECT_EQ(project.resources.memory_gb, 4.0);
}

TEST_F(SurveyProjectTest, ReadsTheOtherFormatsOfMergedClouds) {
  const SurveyProject project = Read(
      "schema_version: 1\nstations: [{id: S1, scan: scans/S1.ptx}, {id: S2, scan: "
      "scans/S2.ptx}]\noutputs: {merged: [{format: pcd, path: a.pcd}, {format: ply, path: "
      "a.ply}]}\n");
  EXPECT_EQ(project.outputs.merged->at(0).format, CloudFormat::kPcd);
  EXPECT_EQ(project.outputs.merged->at(1).format, CloudFormat::kPly);
  EXPECT_EQ(project.outputs.merged->at(1).max_points, 0);
}

TEST_F(SurveyProjectTest, ReadsWhatBecomesOfMovingObjectsAndTheMap) {
  const std::string two =
      "schema_version: 1\nstations: [{id: S1, scan: scans/S1.ptx}, {id: S2, scan: "
      "scans/S2.ptx}]\n";
  EXPECT_FALSE(Read(two).outputs.map);
  EXPECT_EQ(Read(two + "outputs: {map: none}\n").outputs.map->path, "");
  const OutputSpec outputs =
      Read(two +
           "outputs:\n  merged: [{format: las, path: a.las, moving: remove}, {format: las, path: "
           "b.las, moving: mark}]\n  stations: {format: e57, path: out/, moving: remove}\n  map: "
           "{path: m.ot, resolution_m: 0.1}\n")
          .outputs;
  EXPECT_TRUE(outputs.merged->at(0).without_moving);
  EXPECT_FALSE(outputs.merged->at(1).without_moving);
  EXPECT_TRUE(outputs.stations->without_moving);
  EXPECT_EQ(outputs.map->path, (folder_ / "m.ot").string());
  EXPECT_EQ(outputs.map->resolution_m, 0.1);
}

TEST_F(SurveyProjectTest, ReadsE57OutputsAndCropBoxes) {
  const SurveyProject project = Read(
      "schema_version: 1\nstations: [{id: S1, scan: scans/S1.ptx}, {id: S2, scan: "
      "scans/S2.ptx}]\noutputs:\n  merged: [{format: e57, path: a.e57, crop: {min: [1, -2, 3], "
      "max: [4, 5, 6.5]}}]\n  stations: {format: ply, path: out/each/}\n");
  const CloudOutput& merged = project.outputs.merged->at(0);
  EXPECT_EQ(merged.format, CloudFormat::kE57);
  EXPECT_EQ(merged.crop->min, Eigen::Vector3d(1, -2, 3));
  EXPECT_EQ(merged.crop->max, Eigen::Vector3d(4, 5, 6.5));
  EXPECT_EQ(StationCloudPath(*project.outputs.stations, "S2"),
            (folder_ / "out/each/S2.ply").string());
}

TEST_F(SurveyProjectTest, ReadsColumnsOfTextScans) {
  using enum TextColumn;
  const SurveyProject project = Read(R"(schema_version: 1
stations:
  - {id: S1, scan: scans/S1.ptx}
  - {id: S2, scan: scans/S2.txt, columns: [y, x, z, skip]}
)");
  EXPECT_TRUE(project.stations[0].columns.empty());
  EXPECT_EQ(project.stations[1].columns, (TextColumns{kY, kX, kZ, kSkip}));
}

TEST_F(SurveyProjectTest, TheSmallestProjectHasDefaults) {
  const SurveyProject project = Read(
      "schema_version: 1\nstations: [{id: a, scan: scans/S1.ptx}, {id: b, scan: scans/S2.ptx}]\n");
  EXPECT_EQ(project.name, "survey");
  EXPECT_FALSE(project.outputs.merged.has_value());
  EXPECT_FALSE(project.gates.max_station_sigma_mm.has_value());
  EXPECT_EQ(project.resources.threads, 0);
  EXPECT_EQ(options_.resolution_m, 0.1);
}

TEST_F(SurveyProjectTest, ListsFifteenMistakesAtOnce) {
  unsetenv("BACKSIGHT_TEST_UNSET");
  const std::string complaint = Complaint(R"(schema_version: 2
nmae: Town hall
stations:
  - {id: S1, scan: scans/S1.ptx}
  - {id: S1, scan: scans/S2.ptx}
  - {id: "a/b", scan: scans/S3.ptx}
  - {id: S4, scan: scans/missing.ptx}
  - {id: S5, scan: scans/../scans/S1.ptx}
  - {id: S6, scan: "${BACKSIGHT_TEST_UNSET}/S6.ptx"}
  - {id: S7, scan: scans/S2.ptx, scan_index: -1}
  - {id: S8, scan: scans/S2.ptx, scan_index: 3, levelled: yes}
  - {id: S9, scan: scans/S2.ptx, scan_index: 4,
     prior: {survey_from_station: [0, 0, 0, 1, 0, 0, 0], sigma_m: -1, sigma_deg: 5}}
pairs:
  include: [[S1, S44]]
  exclude: [[S4, S4]]
registration:
  resolution_m: 7
outputs:
  merged:
    - {format: laz, path: out/merged.las}
    - {format: las, path: out/merged.las, thin_m: -2}
gates: {require_all_stations: 1}
)");
  for (const char* part :
       {"survey.yaml:1: schema_version: found '2'; expected 1",
        "survey.yaml:2: nmae: found an unknown key",
        "did you mean 'name'?",
        "survey.yaml:5: stations[1].id: found 'S1'",
        "line 4 has the same one",
        "survey.yaml:6: stations[2].id: found 'a/b'",
        "survey.yaml:7: stations[3].scan: found 'scans/missing.ptx'",
        "no such file",
        "survey.yaml:8: stations[4].scan",
        "line 4 has the same scan 0",
        "survey.yaml:9: stations[5].scan",
        "BACKSIGHT_TEST_UNSET is not set",
        "survey.yaml:10: stations[6].scan_index: found '-1'",
        "survey.yaml:11: stations[7].levelled: found 'yes'",
        "write true",
        "survey.yaml:13: stations[8].prior.sigma_m: found '-1'",
        "survey.yaml:16: pairs.exclude[0]: found [S4, S4]; expected two different stations",
        "survey.yaml:18: registration.resolution_m: found '7'",
        "survey.yaml:21: outputs.merged[0].format: found 'laz'",
        "one of: las, ply, pcd, e57",
        "survey.yaml:22: outputs.merged[1].thin_m: found '-2'; expected a number from 0 to 10 m",
        "survey.yaml:23: gates.require_all_stations: found '1'"}) {
    EXPECT_THAT(complaint, HasSubstr(part));
  }
  EXPECT_THAT(complaint, HasSubstr("15 mistakes"));
}

TEST_F(SurveyProjectTest, NamesEveryKindOfMistake) {
  const std::string head = "schema_version: 1\nstations:\n";
  const std::string one = "  - {id: S1, scan: scans/S1.ptx}\n";
  const std::string two = head + one + "  - {id: S2, scan: scans/S2.ptx}\n";
  const std::string station = head + one + "  - {id: S2, scan: scans/S2.ptx, ";
  const std::string crop = "outputs: {merged: [{format: las, path: a.las, crop: ";
  const std::string point = "control: [{id: P, crs: [1, 2, 3], sigma_m: [1, 1, 1], role: ";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {head + one, "survey.yaml:2: stations: found a list of 1; expected at least 2"},
      {"schema_version: 1\n", "required key 'stations'"},
      {two.substr(18), "required key 'schema_version'"},
      {two + "pairs: all\n", "expected auto, or a map"},
      {two + "pairs: [[S1, S2]]\n", "expected auto, or a map"},
      {two + "pairs: {include: [[S1]]}\n", "a list of 2"},
      {two + "pairs: {include: [[S1, S2]], exclude: [[S2, S1]]}\n", "line 5 has the same pair"},
      {two + "pairs: {include: [[S1, s2]]}\n", "did you mean 'S2'?"},
      {two + "crs: {vertical: EPSG:7837}\n", "required key 'horizontal'"},
      {two + "crs: {horizontal: 25832}\n", "like EPSG:25832"},
      {two + point + "checker, measured: [{station: S1, xyz: [1, 2, 3]}]}]\n", "control, check"},
      {two + point + "check, measured: []}]\n", "a list of at least 1"},
      {two + point + "check, measured: [{station: X, xyz: [1, 2, 3]}]}]\n", "the id of a station"},
      {two + point + "check, measured: [{station: S1, xyz: [1, 2]}]}]\n", "a list of 3"},
      {two + "outputs: {merged: [{format: las, path: a.laz}]}\n", "ending in .las"},
      {two + "outputs: {merged: [{format: las, path: a.las}, {format: las, path: ./a.las}]}\n",
       "no other output"},
      {two + "outputs: {merged: [{format: ply, path: a.ply, max_points: 9}]}\n",
       "only LAS files are split"},
      {two + "outputs: {merged: [{format: las, path: a-12.las}, {format: las, path: a.las, "
             "max_points: 9}]}\n",
       "no other output"},
      {two + "outputs: {stations: {format: pdf, path: a}}\n", "one of: las, ply, pcd, e57"},
      {two + "outputs: {stations: {format: las, path: a/}, merged: [{format: las, path: "
             "a/S2.las}]}\n",
       "a folder where no scan or other output is in the way"},
      {two + "outputs: {merged: [{format: e57, path: a.e57, max_points: 9}]}\n",
       "only LAS files are split"},
      {two + crop + "{min: [1, 2, 3], max: [2, 2, 4]}}]}\n", "greater than those of min"},
      {two + crop + "{min: [1, 2, 3], max: [2, 3]}}]}\n", "a list of 3"},
      {two + crop + "{max: [2, 3, 4]}}]}\n", "required key 'min'"},
      {two + crop + "{min: [a, 2, 3], max: [2, 3, 4]}}]}\n", "crop.min[0]: found 'a'"},
      {two + crop + "[1, 2, 3, 4, 5, 6]}]}\n", "merged[0].crop: found a list"},
      {two + "outputs: {merged: [{format: las, path: a.las, moving: hide}]}\n",
       "one of: mark, remove"},
      {two + "outputs: {map: yes}\n", "none, or a map with path"},
      {two + "outputs: {map: {path: map.bt}}\n", "ending in .ot"},
      {two + "outputs: {map: {path: map.ot, resolution_m: 0}}\n", "from 0.01"},
      {two + "gates: {max_station_sigma_mm: 0}\n", "from 0.001"},
      {two + "resources: {memory_gb: 8 GB}\n", "without its unit"},
      {two + "resources: {threads: -1}\n", "from 0 to 4096"},
      {station + "level_sigma_deg: 1}\n", "only together with levelled: true"},
      {station + "scanner_origin_m: [1, 2]}\n", "a list of 3"},
      {station + "colour: red}\n", "stations[1].colour: found an unknown key"},
      {station + "prior: {sigma_m: 1, sigma_deg: 1}}\n", "'survey_from_station'"},
      {station + "prior: {survey_from_station: [1, 2], sigma_m: 1, sigma_deg: 1}}\n",
       "16 numbers (4x4 matrix by rows) or 7 numbers"},
      {station + "prior: {survey_from_station: [0, 0, 0, 2, 0, 0, 0], sigma_m: 1, sigma_deg: 1}}\n",
       "a quaternion of length 2"},
      {station + "prior: {survey_from_station: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1], "
                 "sigma_m: 1, sigma_deg: 1}}\n",
       "a matrix that is not rigid"},
      {station + "prior: {survey_from_station: [a, 0, 0, 1, 0, 0, 0], sigma_m: 1, sigma_deg: 1}}\n",
       "survey_from_station[0]: found 'a'"},
      {station + "columns: [x, y, z]}\n", "columns: found a list of 3; expected no columns"},
      {head + one + "  - {id: S2, scan: scans/S2.txt, columns: [x, y]}\n", "a list of at least 3"},
      {head + one + "  - {id: S2, scan: scans/S2.txt, columns: [x, y, skip]}\n", "no z"},
      {head + one + "  - {id: S2, scan: scans/S2.txt, columns: [x, y, z, z]}\n", "z twice"},
      {head + one + "  - {id: S2, scan: scans/S2.txt, columns: [x, y, z, r, b]}\n",
       "2 of r, g and b"},
      {head + one + "  - {id: S2, scan: scans/S2.txt, columns: [x, y, z, red]}\n",
       "stations[1].columns[3]: found 'red'"},
      {head + one + "  - {id: a__b, scan: scans/S2.ptx}\n", "because it names files"},
      {head + one + "  - {id: S2, scan: scans}\n", "not a file"},
  };
  for (const auto& [text, part] : cases) {
    const std::string complaint = Complaint(text);
    EXPECT_THAT(complaint, HasSubstr(part)) << text;
    EXPECT_THAT(complaint, HasSubstr("1 mistake\n")) << text;
  }
  EXPECT_THROW(ReadSurveyProject("no/such.yaml", {}), InputError);
}

TEST_F(SurveyProjectTest, OneStationIdTwiceIsOneMistake) {
  const std::string complaint = Complaint(
      "schema_version: 1\nstations:\n  - {id: S1, scan: scans/S1.ptx}\n  - {id: S1, scan: "
      "scans/S2.ptx}\npairs: {include: [[S1, S2]]}\ncontrol: [{id: P, crs: [1, 2, 3], sigma_m: "
      "[1, 1, 1], role: check, measured: [{station: S2, xyz: [1, 2, 3]}]}]\noutputs: {stations: "
      "{format: las, path: a/}}\n");
  EXPECT_THAT(complaint, HasSubstr("survey.yaml:4: stations[1].id: found 'S1'"));
  EXPECT_THAT(complaint, HasSubstr("1 mistake\n"));
}

TEST_F(SurveyProjectTest, AsksForFaultsBeyondItsForm) {
  WholeParts seen;
  const auto complaint = [&](const std::string& text, const ProjectFault& fault) {
    std::ofstream(folder_ / "survey.yaml", std::ios::binary) << text;
    try {
      ReadSurveyProject((folder_ / "survey.yaml").string(), options_.Sections(),
                        [&](const SurveyProject&, const WholeParts& whole) {
                          seen = whole;
                          return std::vector<ProjectFault>{fault};
                        });
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string text =
      "schema_version: 1\nstations:\n  - {id: S1, scan: scans/S1.ptx}\n  - {id: S2, scan: "
      "scans/S2.ptx}\ncrs: {horizontal: EPSG:25832}\ncontrol:\n  - {id: P, crs: [1, 2, 3], "
      "sigma_m: [1, 1, 1],\n     role: check, measured: [{station: S1, xyz: [1, 2, 3]}]}\n";
  using enum ProjectFault::Place;
  EXPECT_THAT(complaint(text, {kCrs, 0, 0, "a", "b", "c"}),
              HasSubstr("survey.yaml:5: crs: found a; expected b; c"));
  EXPECT_TRUE(seen.stations && seen.crs && seen.control);
  EXPECT_THAT(complaint(text, {kControl, 0, 0, "a", "b", ""}),
              HasSubstr("survey.yaml:6: control:"));
  EXPECT_THAT(complaint(text, {kPoint, 0, 0, "a", "b", ""}),
              HasSubstr("survey.yaml:7: control[0].crs:"));
  EXPECT_THAT(complaint(text, {kSighting, 0, 0, "a", "b", ""}),
              HasSubstr("survey.yaml:8: control[0].measured[0].xyz:"));
  const std::string faulty =
      complaint(text + "gates: {require_all_stations: 1}\n", {kCrs, 0, 0, "a", "b", ""});
  EXPECT_THAT(faulty, HasSubstr("2 mistakes"));
  EXPECT_TRUE(seen.stations && seen.crs && seen.control);
  std::string wrong = text;
  wrong.replace(wrong.find("EPSG:25832"), 10, "25832");
  complaint(wrong, {kControl, 0, 0, "a", "b", ""});
  EXPECT_TRUE(seen.stations && !seen.crs && seen.control);
}

TEST_F(SurveyProjectTest, NoTwoOutputsMayMeet) {
  std::string head = "schema_version: 1\nstations:\n";
  for (const char* name : {"a_component2", "S2", "S3", "S4"}) {
    head += fmt::format("  - {{id: {0}, scan: scans/{0}.las}}\n", name);
    std::ofstream(folder_ / "scans" / fmt::format("{}.las", name)) << "LASF";
  }
  std::filesystem::create_directory_symlink(folder_ / "scans", folder_ / "link");
  const auto merged = [&](const std::string& first, const std::string& second) {
    return fmt::format(
        "{}outputs: {{merged: [{{format: las, path: {}}}, {{format: las, path: {}}}]}}\n", head,
        first, second);
  };
  const std::string split = ", max_points: 9";
  // Four stations may fall into two components, no more.
  for (const auto& [first, second] : std::vector<std::pair<std::string, std::string>>{
           {"a.las", "a.las"},
           {"o/a.las", "o/../o/a.las"},
           {"a.las", "a_component2.las"},
           {"a_component2.las", "a.las"},
           {"a.las" + split, "a-3.las"},
           {"a-3.las", "a.las" + split},
           {"a.las" + split, "a_component2-1.las"},
           {"a_component2.las" + split, "a.las" + split}}) {
    const std::string complaint = Complaint(merged(first, second));
    EXPECT_THAT(complaint, HasSubstr("outputs.merged[1].path")) << first << " " << second;
    EXPECT_THAT(complaint, HasSubstr("line 7 may write the same file")) << first << " " << second;
    EXPECT_THAT(complaint, HasSubstr("1 mistake\n")) << first << " " << second;
  }
  for (const auto& [first, second] :
       std::vector<std::pair<std::string, std::string>>{{"a.las", "a-1.las"},
                                                        {"a.las", "a_component3.las"},
                                                        {"a.las", "a_component02.las"},
                                                        {"a.las" + split, "a-0.las"},
                                                        {"a.las", "b/a_component2.las"},
                                                        {"a.las" + split, "a-1-1.las"}}) {
    EXPECT_EQ(Complaint(merged(first, second)), "") << first << " " << second;
  }
  // Scans, by their own name and through a link; clouds of stations.
  EXPECT_THAT(Complaint(merged("x.las", "scans/S2.las")), HasSubstr("the scan"));
  EXPECT_THAT(Complaint(merged("x.las", "link/S2.las")), HasSubstr("the scan"));
  EXPECT_THAT(Complaint(merged("x.las", "scans/a.las")), HasSubstr("the scan"));
  EXPECT_THAT(Complaint(head + "outputs: {merged: [{format: las, path: o/a.las}], stations: "
                               "{format: las, path: o}}\n"),
              HasSubstr("a folder where no scan or other output is in the way"));
}

TEST_F(SurveyProjectTest, SurvivesRandomDamage) {
  setenv("BACKSIGHT_TEST_SCANS", (folder_ / "scans").c_str(), 1);
  int valid = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Random random(seed);
    std::string text = kWhole;
    for (std::uint64_t n = 1 + random.Index(4); n > 0; --n) {
      const std::size_t at = random.Index(text.size());
      const char byte = static_cast<char>(random.Index(256));
      switch (random.Index(4)) {
        case 0:
          text[at] = byte;
          break;
        case 1:
          text.erase(at, 1 + random.Index(20));
          break;
        case 2:
          text.insert(at, 1, byte);
          break;
        default:
          text.insert(at, text.substr(random.Index(text.size()), random.Index(40)));
          break;
      }
    }
    try {
      Read(text);
      ++valid;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(valid, 0);
  EXPECT_LT(valid, 2000);
}

}  // namespace
}  // namespace backsight
