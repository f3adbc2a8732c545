#include "stages/occupancy_map.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <memory>
#include <sstream>

#include "core/error.h"
#include "tests/support/moving_scene.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.2;

class OccupancyMap : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    Scene scene = BusyHall(7);
    scene.scanner.step_deg = 0.6;
    campaign_ = new ScannedCampaign(ScanCampaign(scene, ExecutionContext(2)));
  }
  static void TearDownTestSuite() { delete campaign_; }

  static std::vector<MovingLeaves> Moving() {
    return FindMovingLeaves(campaign_->Placed(), {}, ExecutionContext(2));
  }
  static std::string Draw(const std::vector<MovingLeaves>& moving) {
    return DrawOccupancyMap(campaign_->Placed(), moving, {.resolution_m = kResolution},
                            ExecutionContext(2));
  }
  static std::unique_ptr<octomap::OcTree> Read(const std::string& bytes) {
    std::istringstream stream(bytes);
    return std::unique_ptr<octomap::OcTree>(
        dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(stream)));
  }
  static Eigen::Vector3d InSurvey(std::size_t station, const Eigen::Vector3d& point) {
    return campaign_->survey_from_station[station] * point;
  }
  static octomap::OcTreeNode* NodeAt(const octomap::OcTree& map, const Eigen::Vector3d& point) {
    return map.search(octomap::point3d(static_cast<float>(point.x()), static_cast<float>(point.y()),
                                       static_cast<float>(point.z())));
  }

  static ScannedCampaign* campaign_;
};
ScannedCampaign* OccupancyMap::campaign_ = nullptr;

TEST_F(OccupancyMap, HoldsEverySurfaceThatStandsStillAndNoneThatMoves) {
  const std::vector<MovingLeaves> moving = Moving();
  const auto map = Read(Draw(moving));
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(map->getResolution(), kResolution);
  std::size_t gone = 0;
  std::size_t cleared = 0;
  for (std::size_t s = 0; s < moving.size(); ++s) {
    const auto& leaves = campaign_->stations[s].model.leaves;
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      const octomap::OcTreeNode* node = NodeAt(*map, InSurvey(s, leaves[i].cluster.mean));
      if (std::binary_search(moving[s].leaves.begin(), moving[s].leaves.end(), i)) {
        ++gone;
        cleared += node == nullptr || !map->isNodeOccupied(node) ? 1 : 0;
        continue;
      }
      ASSERT_NE(node, nullptr);
      ASSERT_TRUE(map->isNodeOccupied(node));
    }
  }
  EXPECT_GT(gone, 100U);
  EXPECT_GT(static_cast<double>(cleared), 0.7 * static_cast<double>(gone));  // feet touch the floor
}

TEST_F(OccupancyMap, BeamsClearTheirWay) {
  const auto map = Read(Draw(Moving()));
  const auto& leaves = campaign_->stations[0].model.leaves;
  std::size_t known = 0;
  std::size_t asked = 0;
  for (std::size_t i = 0; i < leaves.size(); i += 50) {
    ++asked;
    known += NodeAt(*map, InSurvey(0, 0.5 * leaves[i].cluster.mean)) != nullptr ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(known), 0.95 * static_cast<double>(asked));
  EXPECT_FALSE(map->isNodeOccupied(NodeAt(*map, InSurvey(0, {0.0, 0.0, 0.0}))));
  EXPECT_EQ(NodeAt(*map, InSurvey(0, {0.0, 0.0, 300.0})), nullptr);
}

TEST_F(OccupancyMap, IsTheSameEveryTime) {
  const std::vector<MovingLeaves> moving = Moving();
  EXPECT_EQ(Draw(moving), Draw(moving));
}

TEST_F(OccupancyMap, RefusesAFrameWithItsOriginTooFarAway) {
  std::vector<PlacedSurface> placed = campaign_->Placed();
  for (PlacedSurface& station : placed) station.frame_from_instrument.translation.x() += 6600.0;
  const std::vector<MovingLeaves> none(placed.size());
  EXPECT_THROW(DrawOccupancyMap(placed, none, {.resolution_m = kResolution}, ExecutionContext()),
               InputError);
}

TEST_F(OccupancyMap, RefusesToNeedMoreMemoryThanGiven) {
  const std::vector<MovingLeaves> none(campaign_->stations.size());
  EXPECT_THROW(DrawOccupancyMap(campaign_->Placed(), none,
                                {.resolution_m = 0.05, .memory_bytes = std::size_t{8} << 20U},
                                ExecutionContext()),
               InputError);
}

TEST_F(OccupancyMap, ScalesWhatStationsMeasured) {
  const std::vector<PlacedSurface> placed{campaign_->Placed().front()};
  const std::vector<MovingLeaves> none(1);
  const auto map = Read(DrawOccupancyMap(placed, none, {.resolution_m = kResolution, .scale = 2.0},
                                         ExecutionContext()));
  const auto& leaves = campaign_->stations[0].model.leaves;
  for (std::size_t i = 0; i < leaves.size(); i += 20) {
    const octomap::OcTreeNode* node = NodeAt(*map, InSurvey(0, 2.0 * leaves[i].cluster.mean));
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(map->isNodeOccupied(node));
  }
}

}  // namespace
}  // namespace backsight
