#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/pose_files.h"
#include "io/run_tables.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

TEST(RunTablesData, RefereeAcceptsThem) {
  const std::string referee = "../shared/tools/evaluate.py";
  if (!std::filesystem::exists(referee)) GTEST_SKIP() << "skipped: no data";
  const TestFolder folder;
  const RunRecord run = SampleRun();
  const std::string poses = folder.Write("poses.csv", PosesCsv(run.poses));
  const std::string links = folder.Write("links.csv", LinksCsv(run.links));
  const std::string result = folder.Path("result.json");
  const std::string command = "python3 " + referee + " --json --truth '" + poses + "' --poses '" +
                              poses + "' --links '" + links + "' > '" + result + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream stream(result);
  const auto json = nlohmann::json::parse(stream);
  EXPECT_EQ(json["network"]["placed"], 10);
  EXPECT_EQ(json["network"]["reported"], 8 * 7 / 2 + 1);
  EXPECT_EQ(json["network"]["wrong"], 0);
  EXPECT_LT(json["network"]["te_max_cm"], 1e-9);
  EXPECT_EQ(json["links_fine"]["reported"], 9);
  EXPECT_EQ(json["links_fine"]["wrong"], 0);
}

TEST(PoseFilesData, ReadPublishedGroundTruth) {
  const std::string folder = "../shared/data";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "skipped: no data";
  const auto poses = ReadPoses(folder + "/eth_facade");
  EXPECT_EQ(poses.size(), 7U);
  for (const auto& [station, pose] : poses) EXPECT_TRUE(pose.IsValid()) << station;
  const auto log = ReadRelativeLog(folder + "/3dmatch_kitchen/gt.log");
  EXPECT_FALSE(log.empty());
  for (const auto& [pair, transform] : log) EXPECT_TRUE(transform.IsValid()) << pair.first;
}

}  // namespace
}  // namespace backsight
