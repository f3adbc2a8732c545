#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "tests/e2e/program.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

TEST(Documents, OptionsPageIsWhatTheProgramPrints) {
  EXPECT_EQ(ReadBytes("docs/options.md"), RunProgram("options --markdown").out)
      << "run `make options-doc`";
}

TEST(CommandLine, RefusesNonsenseWithExitCodeTwo) {
  for (const char* arguments : {"", "frobnicate", "run", "run a.yaml --threads -3", "register a"}) {
    EXPECT_EQ(RunProgram(arguments).exit_code, 2) << arguments;
  }
  EXPECT_EQ(RunProgram("--version").exit_code, 0);
  EXPECT_EQ(RunProgram("run --help").exit_code, 0);
}

TEST(CommandLine, RefusesWhatOnlySlurmCouldHeed) {
  for (const std::string option : {"--wait", "--slurm-options=--hold"}) {
    const ProgramRun run = RunProgram("run survey.yaml " + option);
    EXPECT_EQ(run.exit_code, 2) << option;
    EXPECT_THAT(run.err, HasSubstr(option.substr(0, option.find('='))));
    EXPECT_THAT(run.err, HasSubstr("--executor slurm"));
  }
}

TEST(CommandLine, NamesAnUnknownCommandAndTheNearest) {
  const ProgramRun run = RunProgram("rnu survey.yaml");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("'rnu'"));
  EXPECT_THAT(run.err, HasSubstr("did you mean 'run'?"));
}

TEST(CommandLine, EvaluateSaysThatNoStationIsCommon) {
  const ScratchFolder folder;
  const std::string head = "station,tx_m,ty_m,tz_m,qw,qx,qy,qz\n";
  WriteBytes(folder / "poses.csv", head + "A,0,0,0,1,0,0,0\nB,1,0,0,1,0,0,0\n");
  WriteBytes(folder / "truth.csv", head + "S1,0,0,0,1,0,0,0\nS2,1,0,0,1,0,0,0\n");
  const ProgramRun run = RunProgram(
      fmt::format("evaluate '{}' --truth '{}'", folder / "poses.csv", folder / "truth.csv"));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("poses.csv: no station of the truth, but A"));
}

TEST(CommandLine, EvaluateTakesFoldersAndCountsWhatItCannotCompare) {
  const ScratchFolder folder;
  const std::string head = "station,component,status,tx_m,ty_m,tz_m,qw,qx,qy,qz\n";
  WriteBytes(folder / "poses.csv", head +
                                       "S1,0,registered,0,0,0,1,0,0,0\n"
                                       "S2,0,registered,1,0,0,1,0,0,0\n"
                                       "S3,1,registered,0,0,0,1,0,0,0\n");
  std::string truth = head;
  for (int s = 1; s <= 4; ++s) truth += fmt::format("S{0},0,registered,{0},0,0,1,0,0,0\n", s);
  WriteBytes(folder / "truth.csv", truth);
  const ProgramRun run =
      RunProgram(fmt::format("evaluate '{}' --truth '{}'", folder / "", folder / ""));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out, HasSubstr("1 of 6 pairs within 5 deg and 0.5 m; 1 compared, 0 wrong\n"
                                 "5 not compared: the poses do not have both stations placed"));
}

/// The first block of YAML in a document.
std::string YamlOf(const std::string& document) {
  const std::string fence = "```yaml\n";
  const std::size_t begin = document.find(fence) + fence.size();
  return document.substr(begin, document.find("```", begin) - begin);
}

TEST(Documents, TheProjectOfTheReadmeIsValid) {
  const ScratchFolder folder;
  WriteBytes(folder / "survey.yaml", YamlOf(ReadBytes("README.md")));
  std::filesystem::create_directory(folder / "scans");
  for (const char* scan : {"S1.ptx", "S2.ptx", "campaign.e57", "S4.ply", "S5.ply", "S6.txt"}) {
    WriteBytes(folder / ("scans/" + std::string(scan)), "");
  }
  setenv("SCANS", (folder / "scans").c_str(), 1);
  const ProgramRun run = RunProgram(fmt::format("check '{}'", folder / "survey.yaml"));
  unsetenv("SCANS");
  EXPECT_EQ(run.exit_code, 5) << run.err;  // the scans are empty
  EXPECT_THAT(run.out, HasSubstr("4 survey points in ETRS89 / UTM zone 32N, ellipsoidal heights"));
  for (const char* line : {"merged.las, thinned to 0.005 m", "full.las, 500000000 points per file",
                           "still.las, without what moved", "out/registered/S1.e57 and so on",
                           "map.ot, voxels of 0.2 m", "gate: max_station_sigma_mm 5",
                           "gate: max_check_rmse_mm 10", "gate: require_all_stations"}) {
    EXPECT_THAT(run.out, HasSubstr(line));
  }
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(ProjectFile, EveryMistakeIsNamedAtOnceWithItsLine) {
  const ScratchFolder folder;
  for (const char* scan : {"a.ptx", "b.ptx", "c.ptx", "d.ptx"}) WriteBytes(folder / scan, "");
  WriteBytes(folder / "p.yaml", R"(schema_version: 2
crs: {horizontal: EPSG:99999}
stations:
  - {id: S1, scan: a.ptx}
  - {id: S1, scan: b.ptx}
  - {id: S3, scan: missing.ptx}
  - {id: S4, scan: c.ptx, level_sigma_deg: 0.1}
  - {id: S5, scan: d.ptx, colour: red}
control:
  - {id: P1, crs: [690000, 5336000, 500], sigma_m: [1, 1, 1], role: control,
     measured: [{station: S2, xyz: [1, 2, 3]}, {station: S1, xyz: [1200, 3000, 10]}]}
pairs: {exclude: [[S4, S4]]}
outputs:
  merged:
    - {format: laz, path: m.las}
    - {format: las, path: n.las, thin_m: -1}
  map: {path: map.bt}
gates: {max_check_rmse_mm: 0}
resources: {threads: many}
registration: {resolution_m: 7}
)");
  const std::vector<std::pair<int, std::string>> mistakes = {
      {1, "'2'"},
      {2, "found EPSG:99999"},
      {5, "'S1'; expected an id of its own"},
      {6, "no such file"},
      {7, "level_sigma_deg"},
      {8, "stations[4].colour"},
      {9, "1 point with role control, no levelled station"},
      {11, "P1 at 3231.1 m from station S1"},
      {12, "[S4, S4]"},
      {15, "'laz'"},
      {16, "'-1'"},
      {17, "map.bt"},
      {18, "'0'"},
      {19, "'many'"},
      {20, "'7'"}};
  for (const char* command : {"check", "run"}) {
    const ProgramRun run = RunProgram(fmt::format("{} '{}'", command, folder / "p.yaml"));
    EXPECT_EQ(run.exit_code, 2);
    std::vector<std::string> lines = LinesOf(run.err);
    const auto first = std::find_if(lines.begin(), lines.end(), [](const std::string& line) {
      return line.find("15 mistakes") != std::string::npos;
    });
    ASSERT_NE(first, lines.end()) << run.err;
    lines.erase(lines.begin(), std::next(first));
    ASSERT_GE(lines.size(), mistakes.size()) << run.err;
    for (std::size_t i = 0; i < mistakes.size(); ++i) {
      EXPECT_THAT(lines[i], HasSubstr(fmt::format("p.yaml:{}: ", mistakes[i].first)));
      EXPECT_THAT(lines[i], HasSubstr(mistakes[i].second));
      EXPECT_THAT(lines[i], HasSubstr("; expected "));
    }
  }
}

TEST(ProjectFile, AnEmptyOneIsWrongInItsFirstLine) {
  const ScratchFolder folder;
  WriteBytes(folder / "p.yaml", "");
  EXPECT_THAT(RunProgram(fmt::format("check '{}'", folder / "p.yaml")).err, HasSubstr("p.yaml:1:"));
}

/// Control of an otherwise good project.
std::string ControlText(const std::string& crs, const std::vector<std::string>& places) {
  std::string text = "crs: {horizontal: " + crs + "}\ncontrol:\n";
  for (std::size_t k = 0; k < places.size(); ++k) {
    text += fmt::format(
        "  - {{id: P{}, crs: [{}], sigma_m: [1, 1, 1], role: control, measured: [{{station: S1, "
        "xyz: [1, 2, 3]}}]}}\n",
        k + 1, places[k]);
  }
  return text;
}

TEST(ProjectFile, ControlWhereItsSystemIsNotUsedIsRefused) {
  const ScratchFolder folder;
  for (const char* scan : {"a.xyz", "b.xyz"}) {
    WriteBytes(folder / scan, "1 2 3\n4 5 6\n7 8 10\n");
  }
  const auto check = [&](const std::string& control) {
    WriteBytes(folder / "p.yaml", ProjectText({{"S1", "a.xyz"}, {"S2", "b.xyz"}}, control));
    return RunProgram(fmt::format("check '{}'", folder / "p.yaml"));
  };
  const std::vector<std::string> good{"690000, 5336000, 500", "690050, 5336010, 500",
                                      "690020, 5336070, 500"};
  EXPECT_EQ(check(ControlText("EPSG:25832", good)).exit_code, 0);
  const ProgramRun swapped = check(ControlText(
      "EPSG:25832", {"5336000, 690000, 500", "5336010, 690050, 500", "5336070, 690020, 500"}));
  EXPECT_EQ(swapped.exit_code, 2);
  EXPECT_THAT(swapped.err, HasSubstr("3 mistakes"));
  EXPECT_THAT(swapped.err, HasSubstr("control[0].crs: found P1: easting 5336000.000"));
  EXPECT_THAT(swapped.err, HasSubstr("easting and northing swapped?"));
  const ProgramRun unprefixed = check(ControlText("EPSG:31468", good));
  EXPECT_EQ(unprefixed.exit_code, 2);
  EXPECT_THAT(unprefixed.err, HasSubstr("which is latitude"));
}

}  // namespace
}  // namespace backsight
