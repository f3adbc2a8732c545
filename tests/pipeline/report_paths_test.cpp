#include "pipeline/report_paths.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace backsight {
namespace {

namespace fs = std::filesystem;

/// A run of the project `folder`/survey.yaml whose paths are those that the program opens.
RunRecord RunIn(const std::string& folder) {
  RunRecord run;
  run.scans.resize(2);
  run.scans[0].path = folder + "scans/S1.ptx";
  run.scans[0].notes = {"also at " + folder + "scans/S1.txt"};
  run.scans[1].path = "/elsewhere/S2.ptx";
  run.outputs = {{folder + "out/merged.las", "LAS 1.4", "", 5}};
  run.poses.resize(1);
  run.poses[0].reason = folder + "scans/S1.ptx:12: 'abc'; expected a number";
  run.links.resize(1);
  run.links[0].reason = "cannot read '" + folder + "scans/S1.ptx'";
  run.warnings = {"see " + folder + "out/old.las, /elsewhere/" + folder + "x"};
  return run;
}

void ExpectProjectPaths(const RunRecord& run) {
  EXPECT_EQ(run.scans[0].path, "scans/S1.ptx");
  EXPECT_EQ(run.scans[0].notes[0], "also at scans/S1.txt");
  EXPECT_EQ(run.scans[1].path, "/elsewhere/S2.ptx");
  EXPECT_EQ(run.outputs[0].path, "out/merged.las");
  EXPECT_EQ(run.poses[0].reason, "scans/S1.ptx:12: 'abc'; expected a number");
  EXPECT_EQ(run.links[0].reason, "cannot read 'scans/S1.ptx'");
  EXPECT_EQ(run.warnings[0].substr(0, 16), "see out/old.las,");
}

TEST(ReportPaths, AreThoseSeenFromTheProject) {
  for (const std::string folder : {"/projects/town/", "projects/town/", ""}) {
    SCOPED_TRACE(folder);
    ExpectProjectPaths(WithProjectPaths(RunIn(folder), folder + "survey.yaml"));
  }
}

TEST(ReportPaths, MayBeSpelledDifferently) {
  const std::string absolute = (fs::current_path() / "town" / "").string();
  ExpectProjectPaths(WithProjectPaths(RunIn(absolute), "town/survey.yaml"));
}

TEST(ReportPaths, WithinOtherPathsStay) {
  const RunRecord run = WithProjectPaths(RunIn("town/"), "town/survey.yaml");
  EXPECT_EQ(run.warnings[0], "see out/old.las, /elsewhere/town/x");
}

}  // namespace
}  // namespace backsight
