#include "io/pose_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "io/run_tables.h"
#include "tests/io/sample_run.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

template <typename Function>
std::string Complaint(Function&& function) {
  try {
    function();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(PoseFiles, ReadsBackPosesCsv) {
  const TestFolder folder;
  std::vector<PoseRecord> poses = SampleRun().poses;
  poses[10].reason = "no link, \"none\"\nat all";
  const auto records = ReadPoseRecords(folder.Write("poses.csv", PosesCsv(poses)));
  ASSERT_EQ(records.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(records[i].station, poses[i].station);
    EXPECT_EQ(records[i].status, poses[i].status);
    EXPECT_EQ(records[i].component, poses[i].component);
    EXPECT_EQ(records[i].reason, poses[i].reason);
    EXPECT_EQ(records[i].link_count, poses[i].link_count);
    EXPECT_EQ(records[i].survey_from_station.translation, poses[i].survey_from_station.translation);
    EXPECT_LT((records[i].survey_from_station.rotation - poses[i].survey_from_station.rotation)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-14);
  }
  EXPECT_EQ(ReadPoses(folder.Path("poses.csv")).size(), 10U);
}

TEST(PoseFiles, ReadsTruthFolders) {
  const TestFolder folder;
  folder.Write("gt_pose1.txt", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  folder.Write("gt_pose12.txt", "0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n");
  folder.Write("other.txt", "nothing");
  const auto poses = ReadPoses(folder.Path(""));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses.at("s1").translation, Eigen::Vector3d(5, 6, 7));
  EXPECT_LT((poses.at("s12") * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
}

TEST(PoseFiles, ReadsTruthOfCampaignFolders) {
  const TestFolder folder;
  folder.Write("gt_pose1.txt", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  folder.Write("truth.csv", "station,tx_m,ty_m,tz_m,qw,qx,qy,qz\nS1,1,2,3,1,0,0,0\n");
  const auto poses = ReadPoses(folder.Path(""));
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses.at("S1").translation, Eigen::Vector3d(1, 2, 3));
}

TEST(PoseFiles, ReadsRelativeLogs) {
  const TestFolder folder;
  const auto log = ReadRelativeLog(folder.Write("gt.log",
                                                "0\t2\t60\n1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n"
                                                "1 2 60\n0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n"));
  ASSERT_EQ(log.size(), 2U);
  EXPECT_EQ(log.at({"cloud_bin_2", "cloud_bin_0"}).translation, Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ(log.at({"cloud_bin_2", "cloud_bin_1"}).translation, Eigen::Vector3d(1, 2, 3));
}

TEST(PoseFiles, NamesTheDamagedLine) {
  const TestFolder folder;
  const std::string head = "station,status,tx_m,ty_m,tz_m,qw,qx,qy,qz\nA,ok,0,0,0,1,0,0,0\n";
  const auto csv = [&](const std::string& row) {
    return Complaint([&] { ReadPoses(folder.Write("p.csv", head + row)); });
  };
  EXPECT_THAT(csv("B,ok,0,0,0,2,0,0,0\n"), HasSubstr("p.csv:3: a quaternion of length 2"));
  EXPECT_THAT(csv("B,good,0,0,0,1,0,0,0\n"), HasSubstr("p.csv:3: 'good' in column status"));
  EXPECT_THAT(csv("A,ok,0,0,0,1,0,0,0\n"), HasSubstr("p.csv:3: station 'A'"));
  EXPECT_THAT(csv("B,ok,inf,0,0,1,0,0,0\n"), HasSubstr("p.csv:3: 'inf' in column tx_m"));
  const auto log = [&](const std::string& text) {
    return Complaint([&] { ReadRelativeLog(folder.Write("gt.log", text)); });
  };
  EXPECT_THAT(log("0 1 2\n1 0 0 0\n0 1 x 0\n"), HasSubstr("gt.log:3: 'x'"));
  EXPECT_THAT(log("0 1 2\n1 0 0 0\n"), HasSubstr("gt.log:3: ''; expected a number"));
  EXPECT_THAT(log("0 1.5 2\n"), HasSubstr("gt.log:1: 1.5"));
  EXPECT_THAT(log("0 1 2\n2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), HasSubstr("gt.log:2: a matrix"));
  EXPECT_THAT(log(""), HasSubstr("no transform"));
  EXPECT_THAT(Complaint([&] { ReadPoses(folder.Path("none.csv")); }), HasSubstr("no such file"));
  EXPECT_THAT(Complaint([&] { ReadPoses(folder.Path("")); }),
              HasSubstr("truth.csv or files gt_pose<number>.txt"));
}

TEST(PoseFiles, SurvivesRandomDamage) {
  const TestFolder folder;
  const std::string whole = PosesCsv(SampleRun().poses);
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Random random(seed);
    std::string text = whole;
    for (std::uint64_t n = 1 + random.Index(5); n > 0; --n) {
      text[random.Index(text.size())] = static_cast<char>(random.Index(256));
    }
    const std::string path = folder.Write("p.csv", text);
    Complaint([&] { ReadPoses(path); });
    Complaint([&] { ReadRelativeLog(path); });
  }
}

}  // namespace
}  // namespace backsight
