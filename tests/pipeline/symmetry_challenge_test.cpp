#include "pipeline/symmetry_challenge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/pipeline/hall_stations.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

constexpr double kNearAngle = 0.002;  // rad; motions are refined to the millimetre
constexpr double kNearDistance = 0.01;

/// A hall with a screen before either end bay, the same after half a turn. S1 stands in one bay, S2
/// in the middle, where the screens hide what stands in the bays from it, S3 in the other bay. Of
/// the two pieces of furniture, S1 and S3 see one each.
HallStations MakeBays(std::uint64_t seed, bool furnished) {
  HallScene scene = HallScene(seed, {.boxes = 0, .size_m = {18.0, 11.0, 4.0}})
                        .WithBox({2.5, -2.35}, {0.3, 5.3, 4.0})
                        .WithBox({-2.5, 2.35}, {0.3, 5.3, 4.0});
  if (furnished) {
    scene = scene.WithBox({5.8, -2.6}, {5.6, 5.0, 1.0}).WithBox({-5.8, 3.6}, {5.6, 1.2, 3.4});
  }
  const std::vector<Eigen::Vector3d> places = {{-6.5, -2.0, 1.6}, {0.1, 0.2, 1.7}, {6.0, 2.5, 1.6}};
  return {scene, places, seed};
}

/// S1 and S2 with both motions, between which they cannot decide.
Pair Ambiguous(const HallStations& hall, const ExecutionContext& context) {
  Pair pair = HallStations::MakePair(1, 0);
  RegisterPairFrom(hall.stations, {}, context, hall.Truth(1, 0), &pair);
  AddMotion(hall.stations, {}, context, hall.HalfTurned(1, 0), &pair);
  EXPECT_EQ(pair.reason(), VerificationResult::Reason::kAmbiguous);
  return pair;
}

/// A pair that one motion was proposed for.
Pair Accepted(const HallStations& hall, int source, int target, const RigidTransform& motion,
              const ExecutionContext& context) {
  Pair pair = HallStations::MakePair(source, target);
  RegisterPairFrom(hall.stations, {}, context, motion, &pair);
  EXPECT_TRUE(pair.accepted()) << ToString(pair.reason());
  return pair;
}

void Challenge(const std::vector<Station>& stations, const ExecutionContext& context,
               std::vector<Pair>* pairs) {
  ChallengeSymmetries(PairUnits(stations, SurveyOptions(), context, ArtifactStore()), pairs);
}

bool Knows(const Pair& pair, const RigidTransform& motion) {
  return std::any_of(
      pair.candidates.begin(), pair.candidates.end(), [&](const PairCandidate& candidate) {
        return TransformNear(candidate.fine.target_from_source, motion, kNearAngle, kNearDistance);
      });
}

TEST(ChallengeSymmetries, DoubtsWhatTheSymmetryExplainsAsWell) {
  const ExecutionContext context(2);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const HallStations hall = MakeBays(seed, false);
    const Pair ambiguous = Ambiguous(hall, context);
    // Rightly and wrongly accepted: nothing tells the two from each other.
    for (const RigidTransform& motion : {hall.Truth(2, 0), hall.HalfTurned(2, 0)}) {
      std::vector<Pair> pairs = {ambiguous, Accepted(hall, 2, 0, motion, context)};
      Challenge(hall.stations, context, &pairs);
      EXPECT_TRUE(pairs[1].doubtful());
      EXPECT_EQ(pairs[1].reason(), VerificationResult::Reason::kAmbiguous);
      EXPECT_TRUE(Knows(pairs[1], hall.Truth(2, 0))) << "seed " << seed;
      EXPECT_TRUE(Knows(pairs[1], hall.HalfTurned(2, 0))) << "seed " << seed;
    }
  }
}

TEST(ChallengeSymmetries, LeavesWhatFurnitureDecides) {
  const ExecutionContext context(2);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const HallStations hall = MakeBays(seed, true);
    std::vector<Pair> pairs = {Ambiguous(hall, context),
                               Accepted(hall, 2, 0, hall.Truth(2, 0), context)};
    Challenge(hall.stations, context, &pairs);
    EXPECT_TRUE(pairs[1].accepted()) << "seed " << seed << " " << ToString(pairs[1].reason());
    EXPECT_TRANSFORM_NEAR(pairs[1].best()->fine.target_from_source, hall.Truth(2, 0), kNearAngle,
                          kNearDistance);
  }
}

TEST(ChallengeSymmetries, ChallengesPairsOfEitherStationBothWaysRound) {
  const ExecutionContext context(2);
  const HallStations hall = MakeBays(3, false);
  const Pair ambiguous = Ambiguous(hall, context);
  // The shared station, S1 or S2, is target or source of the other pair.
  constexpr std::pair<int, int> kPairs[] = {{2, 0}, {0, 2}, {2, 1}, {1, 2}};
  for (const auto& [source, target] : kPairs) {
    std::vector<Pair> pairs = {
        Accepted(hall, source, target, hall.HalfTurned(source, target), context), ambiguous};
    Challenge(hall.stations, context, &pairs);
    EXPECT_EQ(pairs[0].reason(), VerificationResult::Reason::kAmbiguous) << source << target;
    EXPECT_TRUE(Knows(pairs[0], hall.Truth(source, target))) << source << target;
  }
}

TEST(ChallengeSymmetries, DoesNothingWhereNoPairOfTheStationsIsAmbiguous) {
  const ExecutionContext context(2);
  const HallStations hall = MakeBays(4, false);
  std::vector<Pair> pairs = {Accepted(hall, 1, 0, hall.Truth(1, 0), context),
                             Accepted(hall, 2, 0, hall.HalfTurned(2, 0), context)};
  const RigidTransform before = pairs[1].best()->fine.target_from_source;
  Challenge(hall.stations, context, &pairs);
  for (const Pair& pair : pairs) {
    EXPECT_TRUE(pair.accepted());
    EXPECT_EQ(pair.candidates.size(), 1U);
  }
  EXPECT_EQ(pairs[1].best()->fine.target_from_source.Matrix(), before.Matrix());
}

}  // namespace
}  // namespace backsight
