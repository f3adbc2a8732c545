#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "io/pose_files.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using testing::HasSubstr;

/// A good campaign of four stations, simulated once, to which faults are added.
class BrokenInputs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    ASSERT_EQ(
        RunProgram(fmt::format("simulate tests/e2e/scenes/courtyard.yaml '{}'", *folder_ / ""))
            .exit_code,
        0);
    good_.clear();
    for (const auto& [id, pose] : ReadPoses(*folder_ / "truth.csv")) {
      good_.emplace_back(id, "scans/" + id + ".ptx");
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  /// Runs the good stations and one more whose scan is `scan`.
  static ProgramRun RunWith(const std::string& scan) {
    auto stations = good_;
    stations.emplace_back("BAD", scan);
    WriteBytes(*folder_ / "p.yaml", ProjectText(stations, "outputs: {merged: []}\n"));
    return RunProgram(fmt::format("run '{}'", *folder_ / "p.yaml"));
  }

  /// The fault costs its own station and nothing else, and is named.
  static void ExpectOnlyBadIsLost(const ProgramRun& run, const std::string& reason) {
    EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
    const auto poses = ReadPoses(*folder_ / "out/poses.csv");
    EXPECT_EQ(poses.size(), good_.size());
    EXPECT_FALSE(poses.contains("BAD"));
    EXPECT_THAT(ReadBytes(*folder_ / "out/report.json"), HasSubstr(reason));
  }

  static ScratchFolder* folder_;
  static std::vector<std::pair<std::string, std::string>> good_;
};
ScratchFolder* BrokenInputs::folder_ = nullptr;
std::vector<std::pair<std::string, std::string>> BrokenInputs::good_;

TEST_F(BrokenInputs, MissingScanIsNamedBeforeAnythingIsComputed) {
  const ProgramRun run = RunWith("scans/nowhere.ptx");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("nowhere.ptx"));
  EXPECT_THAT(run.err, HasSubstr("p.yaml:"));
}

TEST_F(BrokenInputs, ReportOfARunThatCouldNotWriteItsCloudDoesNotSayComplete) {
  // No folder can be made below a file; a full disk ends the same way.
  WriteBytes(*folder_ / "file", "");
  const std::string project = *folder_ / "p.yaml";
  const auto run_with = [&](const std::string& path) {
    WriteBytes(
        project,
        ProjectText(good_, "outputs: {map: none, merged: [{format: las, path: " + path + "}]}\n"));
    return RunProgram(fmt::format("run '{}'", project)).exit_code;
  };
  EXPECT_NE(run_with("file/cloud.las"), 0);
  const std::string unfinished = ReadBytes(*folder_ / "out/report.json");
  EXPECT_THAT(unfinished, HasSubstr("\"verdict\": \"Not finished: "));
  EXPECT_THAT(unfinished, HasSubstr("\"exit_code\": 3"));
  EXPECT_THAT(unfinished, HasSubstr("file/cloud.las: still to be written"));
  EXPECT_THAT(ReadBytes(*folder_ / "out/report.html"), HasSubstr("Not finished: "));
  EXPECT_EQ(ReadPoses(*folder_ / "out/poses.csv").size(), good_.size());
  EXPECT_EQ(run_with("cloud.las"), 0);
  EXPECT_THAT(ReadBytes(*folder_ / "out/report.json"), HasSubstr("\"verdict\": \"Complete: "));
}

TEST_F(BrokenInputs, EmptyScanCostsItsStation) {
  WriteBytes(*folder_ / "scans/empty.ptx", "");
  ExpectOnlyBadIsLost(RunWith("scans/empty.ptx"), "empty.ptx");
}

TEST_F(BrokenInputs, GarbageInsideAPtxCostsItsStationAndNamesTheLine) {
  const std::string path = *folder_ / "scans/garbage.ptx";
  std::string bytes = ReadBytes(*folder_ / good_.front().second);
  std::size_t at = 0;
  for (int line = 1; line < 200; ++line) at = bytes.find('\n', at) + 1;
  bytes.insert(at, "the quick brown fox\n");
  WriteBytes(path, bytes);
  ExpectOnlyBadIsLost(RunWith("scans/garbage.ptx"), "garbage.ptx:200");
}

TEST_F(BrokenInputs, ScanOfNothingButNanCostsItsStation) {
  std::string text;
  for (int i = 0; i < 500; ++i) text += "nan nan nan\n";
  WriteBytes(*folder_ / "scans/nan.xyz", text);
  ExpectOnlyBadIsLost(RunWith("scans/nan.xyz"), "nan.xyz");
}

TEST_F(BrokenInputs, SomeNanPointsAreDroppedAndCounted) {
  PointChunk points = ReadAllPoints(*folder_ / good_.front().second);
  std::string text;
  for (std::size_t i = 0; i < points.size(); i += 1) {
    text += fmt::format("{:.4f} {:.4f} {:.4f}\n", points.x[i], points.y[i],
                        points.z[i] + 0.0003 * static_cast<double>(i % 5));
    if (i % 1000 == 0) text += "nan 1.0 2.0\n";
  }
  WriteBytes(*folder_ / "scans/some_nan.xyz", text);
  const ProgramRun run = RunWith("scans/some_nan.xyz");
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_THAT(ReadBytes(*folder_ / "out/report.json"), HasSubstr("NaN or infinite"));
}

TEST_F(BrokenInputs, StationThatOverlapsNothingIsNotPlaced) {
  Random random(7);
  std::string text;
  for (int ball = 0; ball < 40; ++ball) {
    const Eigen::Vector3d center(random.Uniform(-20, 20), random.Uniform(-20, 20),
                                 random.Uniform(-3, 8));
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d p = center + random.Uniform(0.5, 2.0) * random.Rotation().col(0);
      text += fmt::format("{:.4f} {:.4f} {:.4f}\n", p.x(), p.y(), p.z());
    }
  }
  WriteBytes(*folder_ / "scans/alien.xyz", text);
  ExpectOnlyBadIsLost(RunWith("scans/alien.xyz"), "no accepted link");
}

TEST_F(BrokenInputs, CopyOfAStationIsRefused) {
  WriteBytes(*folder_ / "scans/copy.ptx", ReadBytes(*folder_ / good_.back().second));
  ExpectOnlyBadIsLost(RunWith("scans/copy.ptx"), "holds the same points as station");
}

TEST_F(BrokenInputs, NothingUsableEndsWithExitCodeFive) {
  WriteBytes(*folder_ / "scans/e1.ptx", "");
  WriteBytes(*folder_ / "scans/e2.ptx", "");
  WriteBytes(*folder_ / "p.yaml", ProjectText({{"A", "scans/e1.ptx"}, {"B", "scans/e2.ptx"}}, ""));
  EXPECT_EQ(RunProgram(fmt::format("run '{}'", *folder_ / "p.yaml")).exit_code, 5);
  EXPECT_EQ(RunProgram(fmt::format("check '{}'", *folder_ / "p.yaml")).exit_code, 5);
}

TEST_F(BrokenInputs, FifteenMistakesAreNamedAtOnce) {
  WriteBytes(*folder_ / "p.yaml",
             "schema_version: 2\nnmae: x\nstations:\n"
             "  - {id: A, scan: no1.ptx}\n  - {id: A, scan: no2.ptx}\n"
             "  - {id: 'b/c', scna: x.ptx}\n  - {scan: no3.ptx, levelled: perhaps}\n"
             "registration: {resolution_m: -1, min_range: 3}\nfeatures: {keypoints: many}\n"
             "fine: {activation: sideways, rounds: 99}\n"
             "outputs: {merged: [{format: dwg, path: a.dwg, thin_m: -3}]}\n"
             "gates: {max_station_sigma_mm: -5}\n");
  const ProgramRun run = RunProgram(fmt::format("run '{}'", *folder_ / "p.yaml"));
  EXPECT_EQ(run.exit_code, 2);
  const auto mistakes = std::count(run.err.begin(), run.err.end(), '\n') - 1;
  EXPECT_GE(mistakes, 15) << run.err;
  for (const char* word : {"p.yaml:1:", "nmae", "name", "scna", "no1.ptx", "resolution_m",
                           "min_range", "sideways", "dwg", "max_station_sigma_mm"}) {
    EXPECT_THAT(run.err, HasSubstr(word));
  }
}

}  // namespace
}  // namespace backsight
