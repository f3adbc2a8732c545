#include "stages/placement_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/support/hall_scene.h"

namespace backsight {
namespace {

/// Four stations in a row through a hall, each linked with the next; the poses are the true ones.
struct Chain {
  explicit Chain(std::uint64_t seed) {
    const HallScene scene(seed, {.boxes = 10});
    const std::vector<Eigen::Vector3d> places = {
        {-6.5, -3.0, 1.6}, {-2.2, 3.4, 1.7}, {2.3, -3.5, 1.6}, {6.6, 3.0, 1.8}};
    for (const Eigen::Vector3d& place : places) {
      stations.push_back(std::make_unique<HallStation>(scene, place, seed + stations.size()));
    }
    for (const auto& station : stations) surfaces.push_back(station->surface());
    for (std::size_t s = 0; s < stations.size(); ++s) {
      input.stations.push_back(&surfaces[s]);
      input.indices.push_back(&stations[s]->index);
      input.survey_from_station.push_back(stations[0]->world_from_station.Inverse() *
                                          stations[s]->world_from_station);
      input.component.push_back(0);
      if (s == 0) continue;
      const auto station = static_cast<int>(s);
      input.links.push_back({station, station - 1, false});
    }
  }

  /// What follows from a false link between stations `link` and `link` + 1: all behind it stand
  /// wrong, but right with respect to each other. `motion` is of the world.
  PlacementCheckInput Falsified(std::size_t link, const RigidTransform& motion) const {
    PlacementCheckInput wrong = input;
    const RigidTransform first_from_world = stations[0]->world_from_station.Inverse();
    for (std::size_t s = link + 1; s < stations.size(); ++s) {
      wrong.survey_from_station[s] = first_from_world * motion * stations[s]->world_from_station;
    }
    return wrong;
  }

  std::vector<std::unique_ptr<HallStation>> stations;
  std::vector<Surface> surfaces;
  PlacementCheckInput input;
};

/// Motions of the world that show: no wall, floor or ceiling stays where it was but by chance.
std::vector<RigidTransform> FalseMotions() {
  return {{ExpSo3({0.0, 0.0, 1.57}), {2.0, 1.0, -0.8}},
          {ExpSo3({0.4, 0.0, 0.0}), {0.0, 0.0, 0.0}},
          {Eigen::Matrix3d::Identity(), {0.3, 0.2, 1.2}}};
}

PlacementCheckResult Check(const PlacementCheckInput& input,
                           const PlacementCheckOptions& options = {}, int threads = 2) {
  return CheckPlacements(input, options, ExecutionContext(threads));
}

std::vector<std::pair<int, int>> PairsOf(const PlacementCheckResult& result) {
  std::vector<std::pair<int, int>> pairs;
  for (const PlacementConflict& conflict : result.conflicts) {
    EXPECT_GT(conflict.conflict, PlacementCheckOptions{}.max_conflict);
    EXPECT_GE(conflict.blocks_in_view, PlacementCheckOptions{}.min_blocks);
    pairs.emplace_back(conflict.a, conflict.b);
  }
  return pairs;
}

/// The pairs with one station up to `link` and one behind it.
std::vector<std::pair<int, int>> PairsAcross(int link, int stations) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a <= link; ++a) {
    for (int b = link + 1; b < stations; ++b) pairs.emplace_back(a, b);
  }
  return pairs;
}

TEST(CheckPlacements, RefutesTheFalseBridgeOfAChainAndNoOther) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const Chain chain(seed);
    for (std::size_t link = 0; link < chain.input.links.size(); ++link) {
      for (const RigidTransform& motion : FalseMotions()) {
        const PlacementCheckResult result = Check(chain.Falsified(link, motion));
        EXPECT_EQ(result.refuted_bridge, static_cast<int>(link)) << "seed " << seed;
        EXPECT_EQ(PairsOf(result), PairsAcross(static_cast<int>(link), 4)) << "seed " << seed;
      }
    }
  }
}

TEST(CheckPlacements, FindsNothingAgainstARightChain) {
  for (std::uint64_t seed = 3; seed <= 4; ++seed) {
    const PlacementCheckResult result = Check(Chain(seed).input);
    EXPECT_EQ(result.pairs_compared, 6) << "also those that no link joins";
    EXPECT_EQ(result.refuted_bridge, -1) << "seed " << seed;
    EXPECT_TRUE(result.conflicts.empty()) << "seed " << seed;
  }
}

TEST(CheckPlacements, FindsTwoFalseBridgesOneAfterTheOther) {
  const Chain chain(6);
  PlacementCheckInput input = chain.Falsified(0, FalseMotions()[0]);
  const PlacementCheckInput behind = chain.Falsified(2, FalseMotions()[1]);
  input.survey_from_station[3] = behind.survey_from_station[3];
  std::vector<int> refuted;
  for (PlacementCheckResult result = Check(input); result.refuted_bridge >= 0;
       result = Check(input)) {
    ASSERT_LT(refuted.size(), 3U);
    const auto bridge = input.links.begin() + result.refuted_bridge;
    refuted.push_back(bridge->target);
    // Without the bridge, what lies behind it has a frame of its own.
    for (int s = bridge->source; s < 4; ++s) ++input.component[static_cast<std::size_t>(s)];
    input.links.erase(bridge);
  }
  EXPECT_THAT(refuted, testing::UnorderedElementsAre(0, 2));
  EXPECT_TRUE(Check(input).conflicts.empty());
}

TEST(CheckPlacements, NeverRefutesWhatALoopControls) {
  const Chain chain(7);
  PlacementCheckInput input = chain.Falsified(2, FalseMotions()[0]);
  for (PlacedLink& link : input.links) link.loop_controlled = true;
  const PlacementCheckResult controlled = Check(input);
  EXPECT_EQ(controlled.refuted_bridge, -1);
  EXPECT_EQ(PairsOf(controlled), PairsAcross(2, 4)) << "it is said all the same";

  // A loop before the bridge: the bridge alone is refuted.
  input.links.push_back({2, 0, true});
  input.links[2].loop_controlled = false;
  EXPECT_EQ(Check(input).refuted_bridge, 2);
}

TEST(CheckPlacements, ComparesOnlyUsableStationsOfOneFrame) {
  const Chain chain(8);
  PlacementCheckInput input = chain.Falsified(1, FalseMotions()[0]);
  input.component = {0, 0, 1, 1};
  EXPECT_EQ(Check(input).pairs_compared, 2);
  EXPECT_EQ(Check(input).refuted_bridge, -1);
  input.component = {0, 0, 0, -1};
  input.stations[2] = nullptr;
  EXPECT_EQ(Check(input).pairs_compared, 1);
  EXPECT_EQ(Check(input).refuted_bridge, -1);
}

TEST(CheckPlacements, IsTheSameForAnyNumberOfThreads) {
  const Chain chain(9);
  const PlacementCheckInput input = chain.Falsified(0, FalseMotions()[2]);
  const PlacementCheckResult one = Check(input, {}, 1);
  const PlacementCheckResult four = Check(input, {}, 4);
  EXPECT_EQ(one.refuted_bridge, four.refuted_bridge);
  ASSERT_EQ(one.conflicts.size(), four.conflicts.size());
  for (std::size_t i = 0; i < one.conflicts.size(); ++i) {
    EXPECT_EQ(one.conflicts[i].conflict, four.conflicts[i].conflict);
    EXPECT_EQ(one.conflicts[i].blocks_in_view, four.conflicts[i].blocks_in_view);
  }
}

/// A station that measured but a piece of a wall of 1.5 m, some 9 m before it.
struct Peep {
  explicit Peep(const HallScene& scene)
      : world_from_station{Eigen::Matrix3d::Identity(), {0.0, 1.0, 2.2}},
        model([&] {
          std::vector<Eigen::Vector3d> points;
          for (double azimuth = -0.08; azimuth < 0.08; azimuth += 0.004) {
            for (double elevation = -0.08; elevation < 0.08; elevation += 0.004) {
              const Eigen::Vector3d ray = ExpSo3({0.0, -elevation, azimuth}).col(0);
              points.push_back(scene.Hit(world_from_station.translation, ray) -
                               world_from_station.translation);
            }
          }
          return MakeSeenStation(points, 0.1);
        }()),
        features(ComputeFeatures(model, {}, ExecutionContext(1))),
        index(model) {}

  RigidTransform world_from_station;
  StationModel model;
  StationFeatures features;
  CloudIndex index;
};

TEST(CheckPlacements, AsksForEnoughBlocksInView) {
  const HallScene scene(10, {.boxes = 0});
  const HallStation wide(scene, {-3.0, -1.0, 1.6}, 10);
  const Peep peep(scene);
  const Surface wide_surface = wide.surface();
  const Surface peep_surface{peep.model, peep.features.normals, true};
  // The piece of wall hangs in the middle of the hall, 4 m before its place.
  const RigidTransform shift{Eigen::Matrix3d::Identity(), {-4.0, 0.0, 0.0}};
  const PlacementCheckInput input{
      {&wide_surface, &peep_surface},
      {&wide.index, &peep.index},
      {{}, wide.world_from_station.Inverse() * shift * peep.world_from_station},
      {0, 0},
      {{1, 0, false}}};
  const PlacementCheckResult few = Check(input);
  EXPECT_EQ(few.refuted_bridge, -1);
  EXPECT_TRUE(few.conflicts.empty());
  const PlacementCheckResult asked_for_less = Check(input, {.min_blocks = 4});
  EXPECT_EQ(asked_for_less.refuted_bridge, 0);
  ASSERT_EQ(asked_for_less.conflicts.size(), 1U);
  EXPECT_GT(asked_for_less.conflicts[0].conflict, 0.9);
  EXPECT_LT(asked_for_less.conflicts[0].blocks_in_view, 20);
}

}  // namespace
}  // namespace backsight
