#include "stages/occupancy_map.h"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "core/error.h"
#include "io/octomap_file.h"
#include "tests/support/moving_scene.h"

namespace backsight {
namespace {

constexpr double kResolution = 0.2;

octomap::point3d ToOctomap(const Eigen::Vector3d& point) {
  const Eigen::Vector3f p = point.cast<float>();
  return {p.x(), p.y(), p.z()};
}

/// The voxels in which the station measured what stands still.
octomap::KeySet StillVoxels(const octomap::OcTree& map, const PlacedSurface& placed,
                            const MovingLeaves& moving, double scale) {
  octomap::KeySet voxels;
  const auto& leaves = placed.surface.model.leaves;
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    if (std::binary_search(moving.leaves.begin(), moving.leaves.end(), i)) continue;
    const Eigen::Vector3d mean = scale * leaves.Mean(i);
    voxels.insert(map.coordToKey(ToOctomap(placed.frame_from_instrument * mean)));
  }
  return voxels;
}

/// The plain way: voxel by voxel and beam by beam into OctoMap's own tree.
std::string DrawWithOctomap(const std::vector<PlacedSurface>& placed,
                            const std::vector<MovingLeaves>& moving, double scale) {
  octomap::OcTree map(kResolution);
  for (std::size_t s = 0; s < placed.size(); ++s) {
    for (const auto& key : StillVoxels(map, placed[s], moving[s], scale)) {
      map.updateNode(key, true, true);
    }
  }
  for (std::size_t s = 0; s < placed.size(); ++s) {
    if (!placed[s].surface.scanner_credible) continue;
    const octomap::point3d station = ToOctomap(placed[s].frame_from_instrument.translation);
    octomap::KeySet crossed;
    octomap::KeyRay ray;
    for (const auto& end : StillVoxels(map, placed[s], moving[s], scale)) {
      map.computeRayKeys(station, map.keyToCoord(end), ray);
      crossed.insert(ray.begin(), ray.end());
    }
    for (const auto& key : crossed) {
      const octomap::OcTreeNode* node = map.search(key);
      if (node == nullptr || !map.isNodeOccupied(node)) map.updateNode(key, false, true);
    }
  }
  map.updateInnerOccupancy();
  map.prune();
  std::ostringstream bytes;
  map.write(bytes);
  return std::move(bytes).str();
}

class OccupancyMapTest : public ::testing::Test {
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
  static std::string Draw(const std::vector<PlacedSurface>& placed,
                          const std::vector<MovingLeaves>& moving, double scale = 1.0,
                          int threads = 2) {
    const OccupancyMap map = DrawOccupancyMap(
        placed, moving, {.resolution_m = kResolution, .scale = scale}, ExecutionContext(threads));
    const auto keys = map.Keys();
    return OctomapBytes(kResolution, keys,
                        [&](std::size_t i, OctomapBlock& values) { map.Fill(keys[i], values); });
  }
  static std::string Draw(const std::vector<MovingLeaves>& moving) {
    return Draw(campaign_->Placed(), moving);
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
    return map.search(ToOctomap(point));
  }

  static ScannedCampaign* campaign_;
};
ScannedCampaign* OccupancyMapTest::campaign_ = nullptr;

TEST_F(OccupancyMapTest, HoldsEverySurfaceThatStandsStillAndNoneThatMoves) {
  const std::vector<MovingLeaves> moving = Moving();
  const auto map = Read(Draw(moving));
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(map->getResolution(), kResolution);
  std::size_t gone = 0;
  std::size_t cleared = 0;
  for (std::size_t s = 0; s < moving.size(); ++s) {
    const auto& leaves = campaign_->stations[s].model.leaves;
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      const octomap::OcTreeNode* node = NodeAt(*map, InSurvey(s, leaves.Mean(i)));
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

TEST_F(OccupancyMapTest, BeamsClearTheirWay) {
  const auto map = Read(Draw(Moving()));
  const auto& leaves = campaign_->stations[0].model.leaves;
  std::size_t known = 0;
  std::size_t asked = 0;
  for (std::size_t i = 0; i < leaves.size(); i += 50) {
    ++asked;
    known += NodeAt(*map, InSurvey(0, 0.5 * leaves.Mean(i))) != nullptr ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(known), 0.95 * static_cast<double>(asked));
  EXPECT_FALSE(map->isNodeOccupied(NodeAt(*map, InSurvey(0, {0.0, 0.0, 0.0}))));
  EXPECT_EQ(NodeAt(*map, InSurvey(0, {0.0, 0.0, 300.0})), nullptr);
}

TEST_F(OccupancyMapTest, HasTheBytesOfOneThatOctomapDraws) {
  // More stations than are counted, and one that is no witness.
  std::vector<PlacedSurface> placed;
  std::vector<MovingLeaves> moving;
  const std::vector<MovingLeaves> found = Moving();
  for (int round = 0; round < 3; ++round) {
    for (std::size_t s = 0; s < found.size(); ++s) {
      placed.push_back(campaign_->Placed()[s]);
      moving.push_back(found[s]);
    }
  }
  placed[1].surface.scanner_credible = false;
  const std::string plain = DrawWithOctomap(placed, moving, 1.1);
  EXPECT_EQ(Draw(placed, moving, 1.1, 1), plain);
  EXPECT_EQ(Draw(placed, moving, 1.1, 3), plain);
}

TEST_F(OccupancyMapTest, RefusesAFrameWithItsOriginTooFarAway) {
  std::vector<PlacedSurface> placed = campaign_->Placed();
  for (PlacedSurface& station : placed) station.frame_from_instrument.translation.x() += 6600.0;
  const std::vector<MovingLeaves> none(placed.size());
  EXPECT_THROW(DrawOccupancyMap(placed, none, {.resolution_m = kResolution}, ExecutionContext()),
               InputError);
}

TEST_F(OccupancyMapTest, RefusesToNeedMoreMemoryThanGiven) {
  const std::vector<MovingLeaves> none(campaign_->stations.size());
  EXPECT_THROW(DrawOccupancyMap(campaign_->Placed(), none,
                                {.resolution_m = 0.05, .memory_bytes = std::size_t{8} << 20U},
                                ExecutionContext()),
               InputError);
}

TEST_F(OccupancyMapTest, ScalesWhatStationsMeasured) {
  const std::vector<PlacedSurface> placed{campaign_->Placed().front()};
  const std::vector<MovingLeaves> none(1);
  const auto map = Read(Draw(placed, none, 2.0));
  const auto& leaves = campaign_->stations[0].model.leaves;
  for (std::size_t i = 0; i < leaves.size(); i += 20) {
    const octomap::OcTreeNode* node = NodeAt(*map, InSurvey(0, 2.0 * leaves.Mean(i)));
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(map->isNodeOccupied(node));
  }
}

}  // namespace
}  // namespace backsight
