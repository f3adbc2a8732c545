#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stages/simulation/campaign.h"
#include "stages/simulation/moving_geometry.h"
#include "stages/simulation/ray_caster.h"

namespace backsight {
namespace {

Scene SmallScene(Orientation orientation) {
  Scene scene;
  scene.name = "small";
  scene.seed = 12;
  scene.ground.size_m = 60.0;
  scene.ground.slope_deg = {1.0, -0.5};
  scene.ground.undulation_m = 0.05;
  Building building;
  building.center_m = {0.0, 12.0};
  scene.buildings.push_back(building);
  scene.trees.push_back({{4.0, -3.0}, 6.0, 1.5, 500});
  scene.barriers.push_back({{-3.0, 1.0}, {3.0, 1.0}, BarrierKind::kWall, 2.5, 0.3});
  scene.scanner.step_deg = 1.0;
  scene.scanner.orientation = orientation;
  scene.scanner.level_sigma_deg = 0.02;
  scene.stations = {{"S1", {-6.0, -4.0}, 1.7, 30.0}, {"S2", {6.5, 3.0}, 1.6, 200.0}};
  return scene;
}

ControlSite Target(const std::string& id, const Eigen::Vector3d& position, double sigma,
                   double measured_sigma) {
  return {id, position, sigma, measured_sigma, false};
}

TEST(Campaign, SurveyFrameIsTheFirstStation) {
  for (const Orientation o :
       {Orientation::kLevelled, Orientation::kRandomHeading, Orientation::kRandomSo3}) {
    const Campaign campaign = PrepareCampaign(SmallScene(o));
    ASSERT_EQ(campaign.stations.size(), 2U);
    EXPECT_TRUE(campaign.stations[0].survey_from_station.Matrix().isIdentity(0.0));
    EXPECT_TRUE(campaign.stations[1].survey_from_station.IsValid());
    const RigidTransform& world_from_second = campaign.stations[1].world_from_station;
    EXPECT_NEAR(world_from_second.translation.z(), campaign.ground.Height({6.5, 3.0}) + 1.6, 1e-12);
  }
}

TEST(Campaign, LevelledStationsLeanByTheLevellingError) {
  const auto tilt_deg = [](Orientation o) {
    const RigidTransform pose = PrepareCampaign(SmallScene(o)).stations[1].world_from_station;
    return std::acos(std::min(1.0, pose.rotation(2, 2))) * 57.29577951308232;
  };
  EXPECT_LT(tilt_deg(Orientation::kLevelled), 0.1);
  EXPECT_GT(tilt_deg(Orientation::kLevelled), 0.0);
  EXPECT_LT(tilt_deg(Orientation::kRandomHeading), 0.1);
  EXPECT_GT(tilt_deg(Orientation::kRandomSo3), 1.0);
}

/// Every point of S2, carried by the truth into S1's frame, is a surface that S1 must meet in that
/// direction if nothing nearer hides it.
TEST(Campaign, TruthCarriesOneStationsPointsOntoTheOthers) {
  Scene scene = SmallScene(Orientation::kRandomSo3);
  scene.scanner.range_sigma_m = 0.0;
  scene.scanner.mixed_pixels = false;
  const Campaign campaign = PrepareCampaign(scene);
  const StationScan scan = SimulateStation(campaign, 1, ExecutionContext(2));
  const RayCaster caster(campaign.still);
  const RigidTransform first_from_second =
      campaign.stations[0].survey_from_station.Inverse() * campaign.stations[1].survey_from_station;
  const RigidTransform& world_from_first = campaign.stations[0].world_from_station;
  int seen_by_both = 0;
  int missed = 0;
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d p(scan.grid.x[i], scan.grid.y[i], scan.grid.z[i]);
    if (p.isZero()) continue;
    const Eigen::Vector3d in_first = first_from_second * p;
    RayBundle ray;
    ray.count = 1;
    ray.origins[0] = world_from_first.translation;
    ray.directions[0] = world_from_first.rotation * in_first.normalized();
    const RayHit hit = caster.Cast(ray, 200.0, false)[0];
    const double excess = hit.range_m - in_first.norm();
    if (std::abs(excess) < 1e-4) ++seen_by_both;
    if (hit.range_m == 0.0 || excess > 1e-3) ++missed;
  }
  EXPECT_GT(seen_by_both, 3000);
  EXPECT_LT(missed, seen_by_both / 500);  // rays that pass by the very edge of a facet
}

TEST(Campaign, NoiselessTargetsAgreeBetweenStations) {
  Scene scene = SmallScene(Orientation::kRandomHeading);
  scene.control = {Target("P1", {0.0, -6.0, 1.5}, 0.0, 0.0),
                   Target("P2", {-1.0, -9.0, 2.0}, 0.0, 0.0)};
  const Campaign campaign = PrepareCampaign(scene);
  const auto targets = MeasureTargets(campaign);
  ASSERT_EQ(targets.size(), 2U);
  for (const SimulatedTarget& target : targets) {
    ASSERT_EQ(target.measured.size(), 2U);
    for (const TargetMeasurement& m : target.measured) {
      const Eigen::Vector3d survey = campaign.stations[m.station].survey_from_station * m.xyz_m;
      EXPECT_LT((survey - target.true_survey_m).norm(), 1e-9);
    }
  }
}

TEST(Campaign, TargetsAreMeasuredWithinTheirSigma) {
  Scene scene = SmallScene(Orientation::kRandomHeading);
  for (int i = 0; i < 200; ++i) {
    std::string id = std::to_string(i);
    scene.control.push_back(
        Target(id.insert(0, 1, 'P'), {-4.0 + 0.03 * i, -8.0, 1.5}, 0.004, 0.002));
  }
  const Campaign campaign = PrepareCampaign(scene);
  double surveyed = 0.0;
  double measured = 0.0;
  double n = 0.0;
  double m_count = 0.0;
  for (const SimulatedTarget& target : MeasureTargets(campaign)) {
    surveyed += (target.surveyed_m - target.true_survey_m).squaredNorm() / 3.0;
    n += 1.0;
    for (const TargetMeasurement& m : target.measured) {
      const RigidTransform& survey_from_station = campaign.stations[m.station].survey_from_station;
      measured += (survey_from_station * m.xyz_m - target.true_survey_m).squaredNorm() / 3.0;
      m_count += 1.0;
    }
  }
  ASSERT_GT(m_count, 150.0);
  EXPECT_NEAR(std::sqrt(surveyed / n), 0.004, 0.004 * 4.0 / std::sqrt(6.0 * n));
  EXPECT_NEAR(std::sqrt(measured / m_count), 0.002, 0.002 * 4.0 / std::sqrt(6.0 * m_count));
}

TEST(Campaign, TargetsAreNotSeenThroughWallsOrOutOfView) {
  Scene scene = SmallScene(Orientation::kLevelled);
  // Behind the barrier for S1, in front of it for S2; and inside the building for both.
  scene.control = {Target("P1", {0.0, 1.8, 1.0}, 0.001, 0.001),
                   Target("P2", {0.0, 12.0, 1.0}, 0.001, 0.001),
                   Target("P3", {-6.0, -3.8, 0.2}, 0.001, 0.001)};
  const auto targets = MeasureTargets(PrepareCampaign(scene));
  ASSERT_EQ(targets[0].measured.size(), 1U);
  EXPECT_EQ(targets[0].measured[0].station, 1U);
  EXPECT_TRUE(targets[1].measured.empty());
  // Under S1's tripod, below its field of view.
  for (const TargetMeasurement& m : targets[2].measured) EXPECT_NE(m.station, 0U);
}

TEST(Campaign, PeopleMoveBetweenScansAndStayWithinTheirArea) {
  Scene scene = SmallScene(Orientation::kLevelled);
  scene.people = {5, {-5.0, -8.0}, {5.0, -2.0}};
  const GroundModel ground(scene.ground, scene.seed);
  const auto people = [&](std::size_t scan) {
    TriangleMesh mesh;
    AddMovingObjects(scene, ground, scan, mesh);
    return mesh.vertices;
  };
  EXPECT_FALSE(people(0).empty());
  EXPECT_EQ(people(0), people(0));
  EXPECT_NE(people(0), people(1));
  for (const auto& vertex : people(1)) {
    EXPECT_GT(vertex.x(), -6.0F);
    EXPECT_LT(vertex.x(), 6.0F);
    EXPECT_LT(vertex.y(), -1.0F);
  }
}

TEST(Campaign, CarsPassOnTheirLanesAndOnlyWhatMovesIsMarked) {
  Scene scene = SmallScene(Orientation::kLevelled);
  scene.scanner.mixed_pixels = false;
  scene.traffic = {{2, {-9.0, -7.0}, {9.0, -7.0}}};
  const StationScan busy = SimulateStation(PrepareCampaign(scene), 0, ExecutionContext(2));
  scene.traffic.clear();
  const StationScan quiet = SimulateStation(PrepareCampaign(scene), 0, ExecutionContext(2));
  std::size_t moving = 0;
  for (std::size_t i = 0; i < busy.grid.size(); ++i) {
    if (busy.moving[i] != 0) ++moving;
    if (busy.moving[i] != 0 || busy.grid.x[i] == quiet.grid.x[i]) continue;
    EXPECT_EQ(busy.grid.x[i], 0.0);  // a pulse that the car swallowed
  }
  EXPECT_GT(moving, 100U);
  EXPECT_EQ(std::count(quiet.moving.begin(), quiet.moving.end(), 1), 0);
}

TEST(Campaign, SameSeedSameScansForAnyThreadsAnotherSeedDiffers) {
  Scene scene = SmallScene(Orientation::kRandomHeading);
  scene.people = {3, {-5.0, -8.0}, {5.0, -2.0}};
  const auto scan = [](const Scene& s, int threads) {
    return SimulateStation(PrepareCampaign(s), 1, ExecutionContext(threads)).grid;
  };
  const PointChunk one = scan(scene, 1);
  const PointChunk four = scan(scene, 4);
  EXPECT_EQ(one.x, four.x);
  EXPECT_EQ(one.y, four.y);
  EXPECT_EQ(one.z, four.z);
  EXPECT_EQ(one.intensity, four.intensity);
  EXPECT_EQ(one.rgb, four.rgb);
  scene.seed = 13;
  EXPECT_NE(one.x, scan(scene, 1).x);
}

}  // namespace
}  // namespace backsight
