#include "stages/moving_objects.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/moving_scene.h"

namespace backsight {
namespace {

/// Points of a campaign by what they are and what was said of them.
struct Counts {
  double moving = 0.0;
  double moving_found = 0.0;
  double still = 0.0;
  double still_found = 0.0;
};

Counts Count(const ScannedCampaign& campaign, const std::vector<MovingLeaves>& found) {
  Counts counts;
  for (std::size_t s = 0; s < campaign.stations.size(); ++s) {
    const auto& [scan, model, features, index] = campaign.stations[s];
    std::vector<std::uint64_t> keys;
    for (const std::uint32_t leaf : found[s].leaves) keys.push_back(model.leaves.Key(leaf));
    for (std::size_t i = 0; i < scan.grid.size(); ++i) {
      const Eigen::Vector3d point(scan.grid.x[i], scan.grid.y[i], scan.grid.z[i]);
      if (point.isZero(0.0)) continue;
      const double is_found =
          std::binary_search(keys.begin(), keys.end(), model.lattice().Key(point)) ? 1.0 : 0.0;
      (scan.moving[i] != 0 ? counts.moving : counts.still) += 1.0;
      (scan.moving[i] != 0 ? counts.moving_found : counts.still_found) += is_found;
    }
  }
  return counts;
}

std::vector<MovingLeaves> Find(const ScannedCampaign& campaign, int threads = 2) {
  return FindMovingLeaves(campaign.Placed(), {}, ExecutionContext(threads));
}

void Print(const char* scene, const Counts& counts) {
  fmt::print("{}: {:.0f} points moved, {:.2f} % of them found; {:.3f} % of the others\n", scene,
             counts.moving, 100.0 * counts.moving_found / counts.moving,
             100.0 * counts.still_found / counts.still);
}

TEST(MovingObjects, NineTenthsOfPeopleAndCarsAreFoundAndHardlyAnythingElse) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const ScannedCampaign campaign = ScanCampaign(BusyStreet(seed), ExecutionContext(2));
    const std::vector<MovingLeaves> found = Find(campaign);
    const Counts counts = Count(campaign, found);
    Print("street", counts);
    EXPECT_GT(counts.moving, 20000.0);
    EXPECT_GE(counts.moving_found, 0.9 * counts.moving);
    EXPECT_LE(counts.still_found, 0.005 * counts.still);
    double points = 0.0;
    for (const MovingLeaves& station : found) points += static_cast<double>(station.points);
    EXPECT_EQ(points, counts.moving_found + counts.still_found);
  }
}

/// Few stations see a person among pillars and shelves, so the share is of all seeds together.
TEST(MovingObjects, PeopleInAHallAreFoundWhateverWayTheInstrumentsStand) {
  Counts all;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const ScannedCampaign campaign = ScanCampaign(BusyHall(seed), ExecutionContext(2));
    const Counts counts = Count(campaign, Find(campaign));
    Print("hall", counts);
    EXPECT_LE(counts.still_found, 0.005 * counts.still);
    all.moving += counts.moving;
    all.moving_found += counts.moving_found;
  }
  EXPECT_GE(all.moving_found, 0.9 * all.moving);
}

TEST(MovingObjects, NothingIsFoundWhereNothingMoves) {
  Scene scene = BusyStreet(3);
  scene.people.count = 0;
  scene.traffic.clear();
  const ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
  const Counts counts = Count(campaign, Find(campaign));
  EXPECT_EQ(counts.moving, 0.0);
  EXPECT_LE(counts.still_found, 0.002 * counts.still);
}

/// A street that a house closes: from afar its ground gives no echo, but the house above it does.
TEST(MovingObjects, GroundBeforeWhatOthersSeeOverItStandsStill) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Scene scene = BusyStreet(seed);
    scene.people.count = 0;
    scene.traffic.clear();
    scene.ground.slope_deg = {-0.3, 0.0};
    scene.ground.undulation_m = 0.05;
    scene.buildings.push_back({{62.0, 0.0}, {24.0, 11.0}, 90.0});
    const double xs[] = {38.0, 12.0, 4.0, -6.0, -14.0};
    for (std::size_t s = 0; s < scene.stations.size(); ++s) {
      scene.stations[s].position_m = {xs[s], s % 2 == 0 ? 1.0 : -1.0};
    }
    const ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
    const Counts counts = Count(campaign, Find(campaign));
    fmt::print("closed street {}: {:.3f} % marked\n", seed,
               100.0 * counts.still_found / counts.still);
    EXPECT_LE(counts.still_found, 0.002 * counts.still);
  }
}

/// A wall stands between two stations, and people walk on the side of the first.
TEST(MovingObjects, GroundThatOnlyOneStationSeesStandsStill) {
  Scene scene = BusyStreet(8);
  scene.traffic.clear();
  scene.stations.resize(2);
  scene.stations[0].position_m = {-8.0, -1.0};
  scene.stations[1].position_m = {4.0, 0.0};
  scene.barriers.push_back({{-2.0, -9.0}, {-2.0, 9.0}, BarrierKind::kWall, 1.4, 0.3});
  scene.people = {8, {-20.0, -5.0}, {-3.0, 5.0}};
  const ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
  const Counts counts = Count(campaign, Find(campaign));
  Print("walled street", counts);
  EXPECT_GT(counts.moving_found, 0.4 * counts.moving);
  EXPECT_LE(counts.still_found, 0.005 * counts.still);
}

/// Beams pass beside them.
TEST(MovingObjects, ThinPolesStandStill) {
  Scene scene = BusyStreet(9);
  scene.people.count = 0;
  scene.traffic.clear();
  for (int i = 0; i < 24; ++i) {
    Pole pole;
    pole.position_m = {-30.0 + 2.5 * i, i % 2 == 0 ? -0.6 : 0.9};
    pole.height_m = 2.5;
    pole.diameter_m = 0.04;
    pole.lamp = false;
    scene.poles.push_back(pole);
  }
  const ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
  double points = 0.0;
  double marked = 0.0;
  const std::vector<MovingLeaves> found = Find(campaign);
  for (std::size_t s = 0; s < found.size(); ++s) {
    const auto& [scan, model, features, index] = campaign.stations[s];
    const RigidTransform& survey_from_station = campaign.survey_from_station[s];
    for (std::uint32_t i = 0; i < model.leaves.size(); ++i) {
      const Eigen::Vector3d world =
          campaign.world_from_survey * (survey_from_station * model.leaves.Mean(i));
      const bool on_pole = std::any_of(
          scene.poles.end() - 24, scene.poles.end(),
          [&](const Pole& pole) { return (pole.position_m - world.head<2>()).norm() < 0.06; });
      if (!on_pole || world.z() < campaign.ground.Height(world.head<2>()) + 0.2) continue;
      points += model.leaves.Count(i);
      const bool is_marked = std::binary_search(found[s].leaves.begin(), found[s].leaves.end(), i);
      marked += is_marked ? model.leaves.Count(i) : 0.0;
    }
  }
  fmt::print("thin poles: {:.0f} points, {:.2f} % marked\n", points, 100.0 * marked / points);
  EXPECT_GT(points, 500.0);
  EXPECT_LE(marked, 0.05 * points);
}

TEST(MovingObjects, OneThreadFindsWhatManyFind) {
  Scene scene = BusyHall(4);
  scene.scanner.step_deg = 0.6;
  const ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
  const std::vector<MovingLeaves> one = Find(campaign, 1);
  const std::vector<MovingLeaves> many = Find(campaign, 4);
  for (std::size_t s = 0; s < one.size(); ++s) {
    EXPECT_FALSE(one[s].leaves.empty());
    EXPECT_EQ(one[s].leaves, many[s].leaves);
    EXPECT_EQ(one[s].points, many[s].points);
  }
}

TEST(MovingObjects, WhoseScannerIsUnknownIsNoWitness) {
  Scene scene = BusyHall(5);
  scene.scanner.step_deg = 0.6;
  ScannedCampaign campaign = ScanCampaign(scene, ExecutionContext(2));
  for (ScannedStation& station : campaign.stations) station.features.scanner_credible = false;
  campaign.stations.front().features.scanner_credible = true;
  const std::vector<MovingLeaves> found = Find(campaign);
  EXPECT_TRUE(found.front().leaves.empty());
  EXPECT_FALSE(found[1].leaves.empty());
}

}  // namespace
}  // namespace backsight
