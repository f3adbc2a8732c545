#include "stages/coarse_registration.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/structure_images.h"
#include "tests/support/hall_scene.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_correspondences.h"

namespace backsight {
namespace {

constexpr double kDeg = 0.017453292519943295;

CoarseInput InputOf(const SyntheticMatches& matches) {
  CoarseInput input;
  input.correspondences = matches.c;
  input.seed = 5;
  return input;
}

TEST(CoarseRegistration, FindsTheMotionAmongManyOutliers) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SyntheticMatches matches =
        MakeMatches(seed, {.inliers = 60, .outliers = 1500, .noise_m = 0.02});
    const CoarseResult result =
        RegisterCoarse(InputOf(matches), {}, ExecutionContext(1, 0, nullptr));
    ASSERT_EQ(result.status, CoarseResult::Status::kRegistered) << "seed " << seed;
    const CoarseCandidate& best = result.candidates.front();
    EXPECT_TRANSFORM_NEAR(best.target_from_source, matches.target_from_source, 0.2 * kDeg, 0.03);
    EXPECT_GE(best.consensus, 55);
    EXPECT_LT(result.consensus_null, 20);
  }
}

TEST(CoarseRegistration, SaysWhyItFails) {
  const ExecutionContext context(1, 0, nullptr);
  CoarseInput input;
  EXPECT_EQ(RegisterCoarse(input, {}, context).status,
            CoarseResult::Status::kTooFewCorrespondences);
  const SyntheticMatches noise = MakeMatches(3, {.inliers = 0, .outliers = 60});
  const CoarseResult none = RegisterCoarse(InputOf(noise), {}, context);
  EXPECT_TRUE(none.candidates.empty() || none.candidates.front().consensus < 10);
}

/// Two motions, each with its own true correspondences: both must be on the list, and clouds that
/// cannot tell them apart (a constant score) must not make one of them disappear.
TEST(CoarseRegistration, KeepsARivalWithAConsensusOfItsOwn) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SyntheticMatches a = MakeMatches(seed, {.inliers = 50, .outliers = 300, .noise_m = 0.01});
    const SyntheticMatches b = MakeMatches(seed + 50, {.inliers = 45, .noise_m = 0.01});
    CoarseInput input = InputOf(a);
    for (std::size_t row = 0; row < b.c.size(); ++row) {
      input.correspondences.Add(b.c.source[row], b.c.target[row], 10000 + b.c.source_id[row],
                                10000 + b.c.target_id[row]);
    }
    const CoarseResult result = RegisterCoarse(input, {}, ExecutionContext(1, 0, nullptr));
    const auto holds = [&](const RigidTransform& truth) {
      return std::any_of(
          result.candidates.begin(), result.candidates.end(),
          [&](const CoarseCandidate& candidate) {
            return bool(TransformNear(candidate.target_from_source, truth, 0.3 * kDeg, 0.05));
          });
    };
    EXPECT_TRUE(holds(a.target_from_source)) << "seed " << seed;
    EXPECT_TRUE(holds(b.target_from_source)) << "seed " << seed;
    EXPECT_LE(result.candidates.size(), 4U);
  }
}

TEST(CoarseRegistration, ListsDistinctCandidatesByFallingScore) {
  const SyntheticMatches matches =
      MakeMatches(9, {.inliers = 40, .outliers = 800, .noise_m = 0.02});
  const CoarseResult result = RegisterCoarse(InputOf(matches), {}, ExecutionContext(1, 0, nullptr));
  for (std::size_t i = 1; i < result.candidates.size(); ++i) {
    EXPECT_LE(result.candidates[i].cloud_score, result.candidates[i - 1].cloud_score);
  }
}

TEST(CoarseRegistration, GivesTheSameForAnyNumberOfThreads) {
  const SyntheticMatches matches =
      MakeMatches(4, {.inliers = 40, .outliers = 900, .noise_m = 0.02});
  const CoarseResult one = RegisterCoarse(InputOf(matches), {}, ExecutionContext(1, 0, nullptr));
  const CoarseResult four = RegisterCoarse(InputOf(matches), {}, ExecutionContext(4, 0, nullptr));
  ASSERT_EQ(one.candidates.size(), four.candidates.size());
  EXPECT_EQ(one.consensus_null, four.consensus_null);
  for (std::size_t i = 0; i < one.candidates.size(); ++i) {
    EXPECT_EQ(one.candidates[i].target_from_source.Matrix(),
              four.candidates[i].target_from_source.Matrix());
    EXPECT_EQ(one.candidates[i].inliers, four.candidates[i].inliers);
  }
}

/// From a motion that is wrong by a half turn, the hall's structure proposes the true one.
TEST(StructureImages, HoldTheTruthWhereTheMotionIsOffByAHalfTurn) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const HallScene scene(seed, {});
    const HallStation a(scene, {-6.0, -3.0, 1.6}, 10 * seed);
    const HallStation b(scene, {3.0, 2.0, 1.7}, 10 * seed + 1);
    const RigidTransform truth = a.world_from_station.Inverse() * b.world_from_station;
    RigidTransform turn;
    turn.rotation = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
    const RigidTransform wrong = a.world_from_station.Inverse() * turn * b.world_from_station;
    const auto images = FindStructureImages(b.surface(), b.index, a.surface(), a.index, wrong);
    EXPECT_LE(images.size(), 24U);
    EXPECT_TRUE(std::any_of(images.begin(), images.end(),
                            [&](const RigidTransform& image) {
                              return bool(TransformNear(image, truth, 2.0 * kDeg, 0.3));
                            }))
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace backsight
