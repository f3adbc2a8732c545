#include <gtest/gtest.h>

#include <limits>

#include "pipeline/artifacts/pair_units.h"
#include "pipeline/pair_pipeline.h"
#include "tests/pipeline/hall_stations.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

using Reason = VerificationResult::Reason;

constexpr double kNearAngle = 0.002;  // rad; motions are refined to the millimetre
constexpr double kNearDistance = 0.01;

/// Two stations in a hall; without machines in it nothing tells its ends from each other.
HallStations MakeTwo(std::uint64_t seed, int machines) {
  const std::vector<Eigen::Vector3d> places = {{-6.0, -3.0, 1.6}, {3.0, 2.0, 1.7}};
  return {HallScene(seed, {.boxes = machines}), places, seed};
}

Pair RegisterFrom(const HallStations& hall, const RigidTransform& motion) {
  Pair pair = HallStations::MakePair(1, 0);
  RegisterPairFrom(hall.stations, {}, ExecutionContext(1), motion, &pair);
  return pair;
}

void Add(const HallStations& hall, const RigidTransform& motion, Pair* pair) {
  AddMotion(hall.stations, {}, ExecutionContext(1), motion, pair);
}

RigidTransform Best(const Pair& pair) { return pair.best()->fine.target_from_source; }

TEST(AddMotion, LetsATrueMotionWinOverAContradictedOne) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const HallStations hall = MakeTwo(seed, 8);
    Pair pair = RegisterFrom(hall, hall.HalfTurned(1, 0));
    ASSERT_TRUE(pair.doubtful()) << "seed " << seed << " " << ToString(pair.reason());
    Random random(seed);
    Add(hall, Retract(hall.Truth(1, 0), RandomTwist(random, 0.01, 0.1)), &pair);
    EXPECT_TRUE(pair.accepted()) << "seed " << seed << " " << ToString(pair.reason());
    EXPECT_TRANSFORM_NEAR(Best(pair), hall.Truth(1, 0), kNearAngle, kNearDistance) << seed;
    EXPECT_TRUE(pair.best()->predicted);
  }
}

TEST(RegisterPairThoroughly, FindsTheTruthThatAFalseMotionStandsFor) {
  const HallStations hall = MakeTwo(1, 8);
  Pair pair = RegisterFrom(hall, hall.HalfTurned(1, 0));
  ASSERT_FALSE(pair.accepted());
  RegisterPairThoroughly(hall.stations, {}, ExecutionContext(1), &pair);
  EXPECT_TRUE(pair.accepted()) << ToString(pair.reason());
  EXPECT_TRANSFORM_NEAR(Best(pair), hall.Truth(1, 0), kNearAngle, kNearDistance);
  EXPECT_FALSE(pair.best()->predicted) << "key points or votes proposed it";
}

TEST(PairUnits, TellThatASecondTryFailedWhichLeavesThePairAsItWas) {
  const HallStations hall = MakeTwo(1, 8);
  Pair pair = RegisterFrom(hall, hall.HalfTurned(1, 0));
  const SurveyOptions options;
  const ExecutionContext context(1);
  const ArtifactStore nowhere;
  const PairUnits hasty(hall.stations, options, context, nowhere, /*limit_s=*/1e-9);
  EXPECT_FALSE(hasty.Register(PairMethod::kThorough, {}, &pair));
  EXPECT_TRUE(pair.fault.empty()) << pair.fault;
  EXPECT_EQ(pair.candidates.size(), 1U);
}

TEST(AddMotion, DoesNotLetAFalseMotionDisplaceATrueOne) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const HallStations hall = MakeTwo(seed, 8);
    Pair pair = RegisterFrom(hall, hall.Truth(1, 0));
    ASSERT_TRUE(pair.accepted()) << "seed " << seed;
    const RigidTransform before = Best(pair);
    const RigidTransform quarter{ExpSo3({0.0, 0.0, 1.5}), {1.0, 0.5, 0.0}};
    const RigidTransform shift{Eigen::Matrix3d::Identity(), {3.0, -2.0, 0.0}};
    for (const RigidTransform& motion :
         {hall.HalfTurned(1, 0), hall.Moved(1, 0, quarter), hall.Moved(1, 0, shift)}) {
      Add(hall, motion, &pair);
      EXPECT_TRUE(pair.accepted()) << "seed " << seed << " " << ToString(pair.reason());
      EXPECT_EQ(Best(pair).Matrix(), before.Matrix());
      EXPECT_EQ(pair.candidates.size(), 1U) << "nor is it kept as a rival";
    }
  }
}

TEST(AddMotion, DoubtsTheBestWhereAnotherIsAsGood) {
  const HallStations hall = MakeTwo(4, 0);
  Pair pair = RegisterFrom(hall, hall.Truth(1, 0));
  ASSERT_TRUE(pair.accepted());
  Add(hall, hall.HalfTurned(1, 0), &pair);
  EXPECT_EQ(pair.reason(), Reason::kAmbiguous);
  ASSERT_EQ(pair.candidates.size(), 2U);
  const std::size_t truth =
      RotationAngle(Best(pair).rotation, hall.Truth(1, 0).rotation) < 1.0 ? 0 : 1;
  EXPECT_TRANSFORM_NEAR(pair.candidates[truth].fine.target_from_source, hall.Truth(1, 0),
                        kNearAngle, kNearDistance);
  EXPECT_TRANSFORM_NEAR(pair.candidates[1 - truth].fine.target_from_source, hall.HalfTurned(1, 0),
                        kNearAngle, kNearDistance);
}

TEST(AddMotion, DoesNotAddAMotionTwice) {
  const HallStations hall = MakeTwo(5, 0);
  Random random(5);
  const auto about = [&](const RigidTransform& motion) {
    return Retract(motion, RandomTwist(random, 0.01, 0.1));
  };
  Pair pair = RegisterFrom(hall, hall.Truth(1, 0));
  for (int i = 0; i < 3; ++i) Add(hall, about(hall.Truth(1, 0)), &pair);
  EXPECT_EQ(pair.candidates.size(), 1U);
  EXPECT_TRUE(pair.accepted()) << "a motion is no rival of itself: " << ToString(pair.reason());
  for (int i = 0; i < 2; ++i) Add(hall, about(hall.HalfTurned(1, 0)), &pair);
  EXPECT_EQ(pair.candidates.size(), 2U) << "nor is a rival added twice";
}

TEST(AddMotion, LeavesThePairAloneWhereTheAttemptFails) {
  const HallStations hall = MakeTwo(6, 8);
  Pair pair = RegisterFrom(hall, hall.Truth(1, 0));
  RigidTransform broken = hall.Truth(1, 0);
  broken.rotation(0, 0) = std::numeric_limits<double>::quiet_NaN();
  Add(hall, broken, &pair);
  EXPECT_TRUE(pair.fault.empty()) << pair.fault;
  EXPECT_TRUE(pair.accepted());
  EXPECT_EQ(pair.candidates.size(), 1U);
}

/// Priors of 0.3 m and 1 deg, off the truth by what they admit, in the stations' own frames; in
/// S2's the instrument stands at `origin`.
void GivePriors(std::uint64_t seed, const Eigen::Vector3d& origin, HallStations* hall) {
  Random random(seed);
  hall->stations[1].model.scanner_origin = origin;
  for (std::size_t s = 0; s < 2; ++s) {
    Station& station = hall->stations[s];
    const RigidTransform world_from_station =
        hall->world_from_station[s] * station.model.StationFromInstrument().Inverse();
    // A turn about the instrument: about the station's origin it would be a shift as well.
    const RigidTransform off{ExpSo3(RandomNoise(random, 0.01)), RandomNoise(random, 0.2)};
    const RigidTransform to_instrument{Eigen::Matrix3d::Identity(),
                                       -hall->world_from_station[s].translation};
    station.spec.prior =
        StationPrior{to_instrument.Inverse() * off * to_instrument * world_from_station, 0.3, 1.0};
  }
}

TEST(PairPriors, RejectAMotionForThatReasonAndLetTheRivalWin) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    HallStations hall = MakeTwo(seed, 0);
    GivePriors(seed, {40.0, -30.0, 2.0}, &hall);
    Pair pair = RegisterFrom(hall, hall.HalfTurned(1, 0));
    EXPECT_EQ(pair.verdict(), Verdict::kRejected);
    EXPECT_EQ(pair.reason(), Reason::kContradictsPrior) << "seed " << seed;
    Add(hall, hall.Truth(1, 0), &pair);
    EXPECT_TRUE(pair.accepted()) << "seed " << seed << " " << ToString(pair.reason());
    EXPECT_TRANSFORM_NEAR(Best(pair), hall.Truth(1, 0), kNearAngle, kNearDistance);
    // What the priors rule out is no rival either.
    Pair right = RegisterFrom(hall, hall.Truth(1, 0));
    Add(hall, hall.HalfTurned(1, 0), &right);
    EXPECT_TRUE(right.accepted()) << "seed " << seed << " " << ToString(right.reason());
    EXPECT_EQ(right.candidates.size(), 1U);
  }
}

TEST(PairPriors, DecideBetweenTheCandidatesOfARegistration) {
  HallStations hall = MakeTwo(2, 0);
  Pair without = HallStations::MakePair(1, 0);
  RegisterPair(hall.stations, {}, ExecutionContext(1), &without);
  ASSERT_EQ(without.reason(), Reason::kAmbiguous);
  GivePriors(2, {40.0, -30.0, 2.0}, &hall);
  Pair with = HallStations::MakePair(1, 0);
  RegisterPair(hall.stations, {}, ExecutionContext(1), &with);
  EXPECT_NE(with.verdict(), Verdict::kRejected);
  EXPECT_NE(with.reason(), Reason::kAmbiguous);
  EXPECT_TRANSFORM_NEAR(Best(with), hall.Truth(1, 0), kNearAngle, kNearDistance);
  ASSERT_GE(with.candidates.size(), 2U);
  for (std::size_t c = 1; c < with.candidates.size(); ++c) {
    EXPECT_EQ(with.candidates[c].verification.reason, Reason::kContradictsPrior);
  }
}

TEST(PairPriors, OfOneStationSayNothing) {
  HallStations hall = MakeTwo(3, 0);
  GivePriors(3, Eigen::Vector3d::Zero(), &hall);
  hall.stations[0].spec.prior.reset();
  Pair pair = RegisterFrom(hall, hall.HalfTurned(1, 0));
  EXPECT_TRUE(pair.accepted()) << ToString(pair.reason());
}

TEST(PairPriors, AreTakenAtTheirSigmas) {
  // 5 sigma of both priors together are 2.1 m, and 2.3 m with what a turn of 1 deg does over 10 m.
  HallStations hall = MakeTwo(4, 8);
  GivePriors(4, Eigen::Vector3d::Zero(), &hall);
  const RigidTransform prior = hall.stations[0].spec.prior->survey_from_station;
  const auto reason_with = [&](const Eigen::Vector3d& shift) {
    hall.stations[0].spec.prior->survey_from_station.translation = prior.translation + shift;
    return RegisterFrom(hall, hall.Truth(1, 0)).reason();
  };
  EXPECT_EQ(reason_with({1.0, -0.5, 0.5}), Reason::kNone);
  EXPECT_EQ(reason_with({3.5, 0.0, 0.0}), Reason::kContradictsPrior);
  EXPECT_EQ(reason_with({0.0, -3.0, 2.0}), Reason::kContradictsPrior);
}

}  // namespace
}  // namespace backsight
