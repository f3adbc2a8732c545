#include "pipeline/map_output.h"

#include <gmock/gmock.h>
#include <octomap/octomap.h>

#include <filesystem>
#include <memory>

#include "tests/io/scan_files.h"
#include "tests/support/moving_scene.h"

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A coarsely scanned hall as a network of one component.
class MapOutputTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Scene scene = BusyHall(1);
    scene.scanner.step_deg = 1.5;
    ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
    for (ScannedStation& scanned : campaign.stations) {
      Station& station = stations_.emplace_back();
      station.model = std::move(scanned.model);
      station.features = std::move(scanned.features);
      station.index = std::move(scanned.index);
    }
    network_.survey_from_station = campaign.survey_from_station;
    network_.component.assign(stations_.size(), 0);
    network_.parts.emplace_back().stations = {0, 1, 2, 3};
    ground_.enu_from_station.resize(stations_.size());
    map_.path = dir_ / "map.ot";
  }

  OutputFiles Write() {
    return WriteMaps(map_, {ingest_, stations_, network_, ground_, moving_, ArtifactStore(), {}},
                     ExecutionContext());
  }

  void TieToUtm(const Eigen::Vector3d& shift) {
    auto frame = std::make_shared<GeodeticFrame>("EPSG:25832", "", "survey.yaml:3");
    frame->SetOrigin({690000.0, 5336000.0, 520.0});
    ground_.frame = frame;
    ground_.parts.emplace_back().result.status = GeoreferencingResult::Status::kGeoreferenced;
    for (std::size_t s = 0; s < stations_.size(); ++s) {
      ground_.enu_from_station[s] = network_.survey_from_station[s];
      ground_.enu_from_station[s]->translation += shift;
    }
  }

  /// Share of station 0's voxels whose place in the map is occupied.
  double Occupied(const RigidTransform& frame_from_station) const {
    const std::unique_ptr<octomap::AbstractOcTree> file(octomap::AbstractOcTree::read(map_.path));
    const auto& map = dynamic_cast<const octomap::OcTree&>(*file);
    double occupied = 0.0;
    const auto& leaves = stations_[0].model.leaves;
    for (const Eigen::Vector3d& mean : leaves.means()) {
      const Eigen::Vector3f p = (frame_from_station * mean).cast<float>();
      const octomap::OcTreeNode* node = map.search(octomap::point3d(p.x(), p.y(), p.z()));
      occupied += node != nullptr && map.isNodeOccupied(node) ? 1.0 : 0.0;
    }
    return occupied / static_cast<double>(leaves.size());
  }

  TempDir dir_;
  IngestOptions ingest_;
  std::vector<Station> stations_;
  Network network_;
  GeoreferencedNetwork ground_;
  MovingPoints moving_;
  MapOutput map_;
};

TEST_F(MapOutputTest, IsInTheSurveyFrameWithoutControlInACrs) {
  ground_.enu_from_station.assign(stations_.size(),
                                  RigidTransform{Eigen::Matrix3d::Identity(), {7e5, 5e6, 0.0}});
  const OutputFiles written = Write();
  ASSERT_EQ(written.files.size(), 1U);
  EXPECT_EQ(written.files[0].path, map_.path);
  EXPECT_FALSE(written.files[0].points);
  EXPECT_THAT(written.warnings, IsEmpty());
  EXPECT_EQ(Occupied(network_.survey_from_station[0]), 1.0);
}

TEST_F(MapOutputTest, IsInTheTopocentricFrameOfACrs) {
  TieToUtm({40.0, -30.0, 5.0});
  EXPECT_THAT(Write().warnings, IsEmpty());
  EXPECT_EQ(Occupied(*ground_.enu_from_station[0]), 1.0);
  EXPECT_LT(Occupied(network_.survey_from_station[0]), 0.1);
}

TEST_F(MapOutputTest, WhatDoesNotFitIsLeftOutAndAnOlderMapNamed) {
  dir_.File("map.ot", "of an earlier run");
  TieToUtm({9000.0, 0.0, 0.0});
  const OutputFiles written = Write();
  EXPECT_THAT(written.files, IsEmpty());
  EXPECT_THAT(written.warnings,
              ElementsAre(HasSubstr("was not written"), HasSubstr("not written by this run")));
  EXPECT_TRUE(std::filesystem::exists(map_.path));
}

TEST_F(MapOutputTest, NoneIsWrittenWhereNoneIsWanted) {
  SurveyProject project;
  EXPECT_EQ(WantedMap(project, "out").path, "out/map.ot");
  project.outputs.map = MapOutput{};
  map_ = WantedMap(project, "out");
  EXPECT_THAT(Write().files, IsEmpty());
}

}  // namespace
}  // namespace backsight
