#include "tests/campaigns/judge.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>
#include <map>

#include "core/random.h"
#include "io/cloud_writer.h"
#include "io/run_json.h"
#include "io/run_tables.h"
#include "io/scene_file.h"
#include "tests/campaigns/campaign_scenes.h"
#include "tests/campaigns/scene_text.h"
#include "tests/campaigns/town_scene.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// A made-up campaign: stations on a line, 4 m apart, in a box of points that all of them see, and
/// a run whose poses are off by what their covariance states.
class JudgeTest : public testing::Test {
 protected:
  static constexpr int kStations = 40;

  JudgeTest() {
    std::filesystem::create_directories(folder_ / "out");
    Random random(11);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j <= i; ++j) root_(i, j) = (i == j ? 1e-4 : 2e-5) * random.Uniform(0.5, 1.5);
    }
    for (int i = 0; i < kStations; ++i) {
      const std::string id = fmt::format("S{}", i);
      truth_[id] = {random.Rotation(), {4.0 * i, 1.0, 2.0}};
      PoseRecord pose;
      pose.station = id;
      pose.component = 1;
      pose.status = StationStatus::kRegistered;
      pose.covariance = root_ * root_.transpose();
      Vector6d xi;
      for (int k = 0; k < 6; ++k) xi[k] = i == 0 ? 0.0 : random.Normal();
      // The run's frame is that of its first station.
      pose.survey_from_station = Retract(truth_.at("S0").Inverse() * truth_.at(id), root_ * xi);
      poses_.push_back(pose);
    }
    poses_[0].covariance->setZero();
  }

  void AddLink(int source, int target, LinkStatus status, double error_m, double weight) {
    LinkRecord link;
    link.source = fmt::format("S{}", source);
    link.target = fmt::format("S{}", target);
    link.status = status;
    link.correspondences = 100;
    link.network_weight = weight;
    link.fine = truth_.at(link.target).Inverse() * truth_.at(link.source);
    link.fine->translation.x() += error_m;
    links_.push_back(link);
  }

  void WriteScans(double reach_m) {
    for (const auto& [id, pose] : truth_) {
      const RigidTransform station_from_world = pose.Inverse();
      PointChunk chunk;
      for (double x = -reach_m; x <= reach_m; x += 0.4) {
        for (double y = -2.0; y <= 2.0; y += 0.4) {
          const Eigen::Vector3d point =
              station_from_world * (pose.translation + Eigen::Vector3d(x, y, 0.0));
          chunk.x.push_back(point.x()), chunk.y.push_back(point.y()), chunk.z.push_back(point.z());
        }
      }
      CloudWriterSpec spec;
      spec.path = scans_[id] = folder_ / (id + ".ply");
      const auto writer = CreatePlyWriter(spec);
      writer->Write(chunk, 1);
      writer->Finish();
    }
  }

  Judgement JudgeIt() {
    std::vector<PoseRecord> truth;
    for (const auto& [id, pose] : truth_) {
      truth.push_back({.station = id,
                       .component = 0,
                       .status = StationStatus::kRegistered,
                       .reason = "",
                       .survey_from_station = pose,
                       .covariance = std::nullopt});
    }
    WriteBytes(folder_ / "truth.csv", PosesCsv(truth));
    WriteBytes(folder_ / "out/poses.csv", PosesCsv(poses_));
    WriteBytes(folder_ / "out/poses.json", PosesJson(poses_));
    WriteBytes(folder_ / "out/links.csv", LinksCsv(links_));
    return Judge(folder_ / "", scans_);
  }

  const ScratchFolder folder_;
  Matrix6d root_ = Matrix6d::Zero();
  std::map<std::string, RigidTransform> truth_;
  std::vector<PoseRecord> poses_;
  std::vector<LinkRecord> links_;
  ScanPaths scans_;
};

TEST_F(JudgeTest, HonestCovariancesGiveOne) {
  WriteScans(8.0);
  AddLink(1, 0, LinkStatus::kAccepted, 0.01, 1.0);
  const Judgement judgement = JudgeIt();
  EXPECT_EQ(judgement.nees_per_dof.size(), kStations - 1U);
  // 234 degrees of freedom: sigma of the mean is sqrt(2 / 234) = 0.09.
  EXPECT_NEAR(Mean(judgement.nees_per_dof), 1.0, 0.3);
  EXPECT_NEAR(Percentile(judgement.error_to_sigma, 0.68), 1.07, 0.25);
  EXPECT_EQ(judgement.wrong_links, 0);
  EXPECT_EQ(judgement.wrong_pairs, 0);
  EXPECT_EQ(judgement.placeable, kStations);
  EXPECT_EQ(judgement.placed, kStations);
}

TEST_F(JudgeTest, OverconfidenceShows) {
  WriteScans(8.0);
  for (PoseRecord& pose : poses_) *pose.covariance /= 9.0;
  const Judgement judgement = JudgeIt();
  EXPECT_GT(Mean(judgement.nees_per_dof), 5.0);
  EXPECT_GT(Percentile(judgement.error_to_sigma, 0.68), 1.5);
}

TEST_F(JudgeTest, CountsWrongLinksThatTheNetworkKept) {
  WriteScans(8.0);
  AddLink(1, 0, LinkStatus::kAccepted, 0.1, 1.0);
  AddLink(2, 0, LinkStatus::kAccepted, 0.3, 1.0);
  AddLink(3, 0, LinkStatus::kAccepted, 5.0, 0.0);
  AddLink(4, 0, LinkStatus::kRejected, 5.0, 0.0);
  const Judgement judgement = JudgeIt();
  EXPECT_EQ(judgement.pairs_in_full, 4);
  EXPECT_EQ(judgement.accepted_links, 2);
  EXPECT_EQ(judgement.wrong_links, 1);
  EXPECT_EQ(judgement.outvoted_links, 1);
  EXPECT_EQ(judgement.outvoted_wrong, 1);
  EXPECT_THAT(judgement.faults.at(0), HasSubstr("wrong link S2-S0"));
}

TEST_F(JudgeTest, MissedAndMisplacedStationsShow) {
  WriteScans(8.0);
  AddLink(7, 6, LinkStatus::kRejected, 5.0, 0.0);
  poses_[7].status = StationStatus::kNotRegistered;
  poses_[9].survey_from_station.translation.y() += 0.5;
  poses_[11].component = 2;
  const Judgement judgement = JudgeIt();
  EXPECT_EQ(judgement.placeable, kStations);
  EXPECT_EQ(judgement.placed, kStations - 2);
  EXPECT_EQ(judgement.components, 2);
  EXPECT_EQ(judgement.wrong_pairs, kStations - 3);
  EXPECT_NEAR(judgement.max_te_m, 0.5, 0.02);
  EXPECT_THAT(judgement.faults, testing::Contains(HasSubstr("not placed S7")));
  EXPECT_THAT(judgement.faults, testing::Contains(HasSubstr("S7-S6 rejected")));
}

TEST_F(JudgeTest, StationsOutOfSightAreNotPlaceable) {
  WriteScans(1.5);
  EXPECT_EQ(JudgeIt().placeable, 0);
}

TEST(CampaignScenes, SurviveTheirOwnFileAndDifferBySeed) {
  const ScratchFolder folder;
  for (const auto& scene : {RepeatedStreet, Forest, TwoBuildings, RingCorridor, Town}) {
    const std::string text = SceneText(scene(3));
    EXPECT_EQ(text, SceneText(scene(3)));
    EXPECT_NE(text, SceneText(scene(4)));
    WriteBytes(folder / "scene.yaml", text);
    EXPECT_EQ(SceneText(ReadScene(folder / "scene.yaml")), text);
  }
}

}  // namespace
}  // namespace backsight
