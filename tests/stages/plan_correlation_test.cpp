#include "stages/plan_correlation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "stages/plan_motions.h"
#include "tests/support/hall_scene.h"

namespace backsight {
namespace {

constexpr double kCell = 0.4;
constexpr std::size_t kSamples = 100;
constexpr std::uint64_t kSeeds = 4;

const Eigen::Vector3d kSourcePlace(-4.5, -2.5, 1.9);
const Eigen::Vector3d kTargetPlace(3.0, 2.0, 1.4);

/// A hall with ten boxes, none of them below an instrument.
HallScene FurnishedHall(std::uint64_t seed) {
  Random random(seed);
  HallScene scene(seed, {.boxes = 0});
  for (int boxes = 0; boxes < 10;) {
    const double x = random.Uniform(-7.5, 7.5);
    const Eigen::Vector2d center(x, random.Uniform(-4.4, 4.4));
    const double nearest = std::min((center - kSourcePlace.head<2>()).norm(),
                                    (center - kTargetPlace.head<2>()).norm());
    if (nearest < 2.0) continue;
    const double width = random.Uniform(0.6, 2.0);
    const double depth = random.Uniform(0.6, 1.6);
    scene = scene.WithBox(center, {width, depth, random.Uniform(0.8, 2.2)});
    ++boxes;
  }
  return scene;
}

/// Two looks at a furnished hall, and the motion between them.
struct Looks {
  explicit Looks(std::uint64_t seed)
      : scene(FurnishedHall(seed)),
        source(scene, kSourcePlace, seed + 100),
        target(scene, kTargetPlace, seed + 200),
        source_view(source.model, source.features, kCell, kSamples),
        target_view(target.model, target.features, kCell, kSamples),
        truth(target.world_from_station.Inverse() * source.world_from_station) {}

  HallScene scene;
  HallStation source;
  HallStation target;
  PlanView source_view;
  PlanView target_view;
  RigidTransform truth;
};

double TurnDeg(const RigidTransform& a, const RigidTransform& b) {
  return RotationAngle(a.rotation, b.rotation) * 180.0 / std::numbers::pi;
}

double PlaceDifference(const RigidTransform& a, const RigidTransform& b) {
  return (a.translation - b.translation).head<2>().norm();
}

bool IsNear(const RigidTransform& a, const RigidTransform& b) {
  return TurnDeg(a, b) < 5.0 && PlaceDifference(a, b) < 2.0 * kCell;
}

const Looks& LooksAt(std::uint64_t seed) {
  static std::map<std::uint64_t, Looks> looks;
  return looks.try_emplace(seed, seed).first->second;
}

TEST(PlanCorrelation, FindsTheTruthAmongTheBest) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Looks& looks = LooksAt(seed);
    const auto matches = CorrelatePlans(looks.source_view, looks.target_view, {.matches = 3});
    // But for its boxes the hall looks the same turned by half, so that the turn may come first.
    const auto found = std::find_if(matches.begin(), matches.end(), [&](const PlanMatch& match) {
      return IsNear(match.target_from_source, looks.truth);
    });
    ASSERT_NE(found, matches.end()) << "seed " << seed;
    // The instruments stand at heights that differ by half a metre.
    EXPECT_NEAR(found->target_from_source.translation.z(), 0.5, 0.15) << "seed " << seed;
  }
}

TEST(PlanCorrelation, FewerHeadingsAreThoseThatMatter) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Looks& looks = LooksAt(seed);
    const auto all = CorrelatePlans(looks.source_view, looks.target_view, {.matches = 1});
    const auto few =
        CorrelatePlans(looks.source_view, looks.target_view, {.tried_turns = 24, .matches = 1});
    ASSERT_EQ(few.size(), 1U);
    EXPECT_EQ(few[0].score, all[0].score);
    EXPECT_EQ(few[0].target_from_source.translation, all[0].target_from_source.translation);
  }
}

/// What a motion by whole cells without a turn is worth, wall by wall.
int VotesFor(const PlanView& source, const PlanView& target, int dx, int dy) {
  int votes = 0;
  for (const PlanWall& wall : source.sample()) {
    votes +=
        target.field().At(FacingSector(wall.facing_rad), target.CellOf(wall.position_m.x()) + dx,
                          target.CellOf(wall.position_m.y()) + dy);
  }
  for (const PlanWall& wall : target.sample()) {
    votes +=
        source.field().At(FacingSector(wall.facing_rad), source.CellOf(wall.position_m.x()) - dx,
                          source.CellOf(wall.position_m.y()) - dy);
  }
  return votes;
}

TEST(PlanCorrelation, VotesAreThoseOfEveryWallForEveryPlace) {
  const Looks& looks = LooksAt(3);
  const auto matches =
      CorrelatePlans(looks.source_view, looks.target_view, {.turns = 1, .tried_turns = 1});
  ASSERT_FALSE(matches.empty());
  int most = 0;
  constexpr int kReach = PlanField::kCells / 2 - 2;
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      most = std::max(most, VotesFor(looks.source_view, looks.target_view, dx, dy));
    }
  }
  const double whole = 2.0 * kSamples * PlanField::kWall;
  EXPECT_DOUBLE_EQ(matches.front().score, most / whole);
  for (const PlanMatch& match : matches) {
    const Eigen::Vector3d cells = match.target_from_source.translation / kCell;
    EXPECT_DOUBLE_EQ(match.score, VotesFor(looks.source_view, looks.target_view,
                                           static_cast<int>(std::lround(cells.x())),
                                           static_cast<int>(std::lround(cells.y()))) /
                                      whole);
  }
}

TEST(PlanCorrelation, MatchesAreDistinctAndFallInScore) {
  const Looks& looks = LooksAt(2);
  const auto matches = CorrelatePlans(looks.source_view, looks.target_view, {.matches = 20});
  ASSERT_EQ(matches.size(), 20U);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_LE(matches[i].score, matches[i > 0 ? i - 1 : 0].score);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_FALSE(TurnDeg(matches[i].target_from_source, matches[k].target_from_source) < 9.9 &&
                   PlaceDifference(matches[i].target_from_source, matches[k].target_from_source) <
                       1.9 * kCell);
    }
  }
}

TEST(PlanCorrelation, NothingUprightMatchesNothing) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(0.1 * i, 0.0, -1.5);
  const StationModel floor = MakeSeenStation(points, 0.1);
  StationFeatures features;
  features.normals.assign(floor.leaves.size(), Eigen::Vector3f::UnitZ());
  features.normals.front().setConstant(std::nanf(""));
  const PlanView view(floor, features, PlanCellFor(floor, features), kSamples);
  EXPECT_TRUE(view.walls().empty());
  EXPECT_TRUE(CorrelatePlans(view, view, {}).empty());
}

TEST(PlanView, CellsAreDoubledUntilTheViewHoldsTheWalls) {
  const Looks& looks = LooksAt(1);
  // The hall is 18 m by 11 m, so that 20 m either way hold it: 50 cells of four voxels of 0.1 m.
  EXPECT_DOUBLE_EQ(PlanCellFor(looks.source.model, looks.source.features), 0.4);
  const HallScene large(1, {.boxes = 10, .size_m = {60.0, 40.0, 5.0}});
  const HallStation station(large, {0.0, 0.0, 1.6}, 5);
  EXPECT_DOUBLE_EQ(PlanCellFor(station.model, station.features), 0.8);
}

TEST(PlanMotions, AreClimbedToTheTruth) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Looks& looks = LooksAt(seed);
    const auto source_surface = SampleSurface(looks.source.model, 400);
    const auto target_surface = SampleSurface(looks.target.model, 400);
    const auto motions =
        FindPlanMotions({looks.source.model, looks.source_view, source_surface},
                        {looks.target.model, looks.target_view, target_surface}, {});
    ASSERT_FALSE(motions.empty());
    EXPECT_LT(TurnDeg(motions.front().motion, looks.truth), 2.5);
    EXPECT_LT(PlaceDifference(motions.front().motion, looks.truth), kCell);
    // What settles on the truth cannot be worth much less than the truth itself.
    EXPECT_GE(motions.front().score,
              MutualViewScore(source_surface, looks.source.model, target_surface,
                              looks.target.model, looks.truth) -
                  0.1);
  }
}

TEST(PlanMotions, ViewsOfTheTruthAgreeAndOfAShiftContradict) {
  const Looks& looks = LooksAt(4);
  const auto source_surface = SampleSurface(looks.source.model, 400);
  const auto target_surface = SampleSurface(looks.target.model, 400);
  const auto score = [&](const RigidTransform& motion) {
    return MutualViewScore(source_surface, looks.source.model, target_surface, looks.target.model,
                           motion);
  };
  // Half of the image's pixels hold no ray and say nothing.
  EXPECT_GT(score(looks.truth), 0.4);
  RigidTransform shifted = looks.truth;
  shifted.translation += Eigen::Vector3d(5.0, 0.0, 0.0);
  EXPECT_LT(score(shifted), score(looks.truth) - 0.3);
}

}  // namespace
}  // namespace backsight
