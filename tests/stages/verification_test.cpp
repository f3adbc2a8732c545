#include "stages/verification.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "stages/cloud_agreement.h"
#include "tests/support/hall_scene.h"

namespace backsight {
namespace {

constexpr double kDeg = 0.017453292519943295;

struct Judged {
  FineResult fine;
  VerificationResult result;
};

/// A pair's verdict at a given motion, taken as refined, with a consensus far from chance.
VerificationResult Judge(const HallStation& source, const HallStation& target,
                         const RigidTransform& motion, std::optional<int> consensus = 40,
                         const VerificationOptions& options = {},
                         FineResult::Status status = FineResult::Status::kRefined) {
  FineResult fine;
  fine.status = status;
  fine.target_from_source = motion;
  fine.weakest_sigma_m = 0.001;
  Matrix6d information = Matrix6d::Identity();
  information *= 1e6;
  return VerifyPair({source.surface(), target.surface(), source.index, target.index, motion,
                     information, consensus, 4, fine, std::nullopt},
                    options);
}

class Verification : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = new HallScene(7, {.boxes = 8});
    first_ = new HallStation(*scene_, {-6.0, -3.0, 1.6}, 11);
    second_ = new HallStation(*scene_, {3.0, 2.0, 1.7}, 12);
  }
  static void TearDownTestSuite() {
    delete second_;
    delete first_;
    delete scene_;
  }
  static RigidTransform Truth() {
    return first_->world_from_station.Inverse() * second_->world_from_station;
  }
  /// The same hall entered from the other side: walls, floor and ceiling coincide.
  static RigidTransform HalfTurned() {
    RigidTransform turn;
    turn.rotation = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
    return first_->world_from_station.Inverse() * turn * second_->world_from_station;
  }

  static HallScene* scene_;
  static HallStation* first_;
  static HallStation* second_;
};
HallScene* Verification::scene_ = nullptr;
HallStation* Verification::first_ = nullptr;
HallStation* Verification::second_ = nullptr;

TEST_F(Verification, AcceptsTheTruth) {
  const VerificationResult result = Judge(*second_, *first_, Truth());
  EXPECT_EQ(result.verdict, Verdict::kAccepted) << ToString(result.reason);
  EXPECT_LT(result.worst_conflict(), 0.02);
  EXPECT_GT(result.overlap, 0.3);
}

TEST_F(Verification, TellsTheTruthFromTheHalfTurn) {
  const VerificationResult truth = Judge(*second_, *first_, Truth());
  const VerificationResult turned = Judge(*second_, *first_, HalfTurned());
  EXPECT_TRUE(IsClearlyBetter(truth, turned));
  EXPECT_FALSE(IsClearlyBetter(turned, truth));
  EXPECT_GT(turned.worst_conflict(), 0.02) << "boxes were seen through";
}

/// Stations on mirrored places of an empty hall: the half turn lays one upon the other, so that
/// both sample the walls alike, and fits better than the truth.
TEST(Rivals, MirroredPlacesAreNotPreferred) {
  double better_by = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const HallScene scene(seed, {.boxes = 0});
    const HallStation a(scene, {-7.0, -3.0, 1.6}, seed);
    const HallStation b(scene, {7.1, 2.9, 1.6}, seed + 10);
    RigidTransform turn;
    turn.rotation = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
    const RigidTransform frame = a.world_from_station.Inverse();
    const VerificationResult truth = Judge(b, a, frame * b.world_from_station);
    const VerificationResult turned = Judge(b, a, frame * turn * b.world_from_station);
    EXPECT_LT(turned.apart_m, 1.0);
    EXPECT_NEAR(truth.apart_m,
                (b.world_from_station.translation - a.world_from_station.translation).norm(), 1e-9);
    EXPECT_FALSE(IsClearlyBetter(turned, truth)) << "seed " << seed;
    better_by = std::max(better_by, turned.quality.value - truth.quality.value);
  }
  std::printf("an empty hall's half turn fits better by up to %.3f\n", better_by);
}

TEST_F(Verification, RejectsAMotionThroughAWall) {
  RigidTransform shifted = Truth();
  shifted.translation += Eigen::Vector3d(0.0, 0.0, 1.2);
  const VerificationResult result = Judge(*second_, *first_, shifted);
  EXPECT_NE(result.verdict, Verdict::kAccepted);
}

TEST_F(Verification, AsksForMoreThanChance) {
  EXPECT_TRUE(IsSignificant(10, 6, {}));
  EXPECT_FALSE(IsSignificant(9, 0, {}));
  EXPECT_FALSE(IsSignificant(13, 10, {}));
  EXPECT_EQ(Judge(*second_, *first_, Truth(), 7).verdict, Verdict::kAccepted)
      << "the clouds prove it";
  VerificationOptions strict;
  strict.sure_quality = 1.0;
  const VerificationResult result = Judge(*second_, *first_, Truth(), 7, strict);
  EXPECT_EQ(result.verdict, Verdict::kDoubtful) << "the clouds speak for it";
  EXPECT_EQ(result.reason, VerificationResult::Reason::kNotSignificant);
}

TEST_F(Verification, DoesNotAskAPredictedPairForConsensusButForProofByTheClouds) {
  EXPECT_EQ(Judge(*second_, *first_, Truth(), std::nullopt).verdict, Verdict::kAccepted);
  VerificationOptions strict;
  strict.sure_quality = 1.0;
  EXPECT_EQ(Judge(*second_, *first_, Truth(), std::nullopt, strict).verdict, Verdict::kDoubtful);
}

/// The truth's verdict between stations levelled to 0.01 degrees.
VerificationResult JudgeLevelled(const HallStation& source, const HallStation& target,
                                 const RigidTransform& truth, std::optional<int> consensus,
                                 double weakest_sigma_m, const VerificationOptions& options) {
  FineResult fine;
  fine.status = FineResult::Status::kRefined;
  fine.target_from_source = truth;
  fine.weakest_sigma_m = weakest_sigma_m;
  Matrix6d information = Matrix6d::Identity();
  information *= 1e6;
  return VerifyPair({source.surface(), target.surface(), source.index, target.index, truth,
                     information, consensus, 4, fine, 0.01 * kDeg},
                    options);
}

TEST_F(Verification, LevelledPairsWhoseMotionsWereComparedNeedLessFit) {
  VerificationOptions options;
  options.sure_quality = 1.0;
  options.level_quality = 0.6;
  const auto verdict = [&](std::optional<int> consensus) {
    return JudgeLevelled(*second_, *first_, Truth(), consensus, 0.001, options).verdict;
  };
  EXPECT_EQ(verdict(7), Verdict::kAccepted);
  EXPECT_EQ(verdict(std::nullopt), Verdict::kDoubtful) << "of a prediction nothing was compared";
  options.level_quality = 1.0;
  EXPECT_EQ(verdict(7), Verdict::kDoubtful);
  EXPECT_EQ(
      Judge(*second_, *first_, Truth(), 7, {.sure_quality = 1.0, .level_quality = 0.6}).verdict,
      Verdict::kDoubtful)
      << "not levelled";
}

TEST_F(Verification, RejectsPredictionsThatTheCloudsDoNotFit) {
  VerificationOptions options;
  options.min_quality = 1.0;
  const VerificationResult predicted =
      JudgeLevelled(*second_, *first_, Truth(), std::nullopt, 0.001, options);
  EXPECT_EQ(predicted.verdict, Verdict::kRejected);
  EXPECT_EQ(predicted.reason, VerificationResult::Reason::kNotSignificant);
  EXPECT_EQ(JudgeLevelled(*second_, *first_, Truth(), 40, 0.001, options).verdict,
            Verdict::kAccepted);
}

TEST_F(Verification, RejectsPredictionsThatLeaveADirectionOpen) {
  constexpr double kOpen = 0.2;  // m; a voxel is 0.1 m
  const VerificationResult predicted =
      JudgeLevelled(*second_, *first_, Truth(), std::nullopt, kOpen, {});
  EXPECT_EQ(predicted.verdict, Verdict::kRejected);
  EXPECT_EQ(predicted.reason, VerificationResult::Reason::kUndetermined);
  EXPECT_EQ(JudgeLevelled(*second_, *first_, Truth(), 40, kOpen, {}).verdict, Verdict::kDoubtful);
}

TEST_F(Verification, RejectsPredictionsThatNothingRefined) {
  const auto judge = [](std::optional<int> consensus, FineResult::Status status) {
    return Judge(*second_, *first_, Truth(), consensus, {}, status);
  };
  using Status = FineResult::Status;
  const VerificationResult unrefined = judge(std::nullopt, Status::kTooFewPlanes);
  EXPECT_EQ(unrefined.verdict, Verdict::kRejected) << "it only repeats the prediction";
  EXPECT_EQ(unrefined.reason, VerificationResult::Reason::kUndetermined);
  EXPECT_EQ(judge(std::nullopt, Status::kRefined).verdict, Verdict::kAccepted);
  EXPECT_EQ(judge(40, Status::kTooFewPlanes).verdict, Verdict::kAccepted)
      << "its key points found it";
}

TEST_F(Verification, DoubtsWhatOnlyThePatternOfTheBeamsHolds) {
  const HallStation beside_first(*scene_, {-6.3, -2.6, 1.6}, 13);
  const RigidTransform beside =
      first_->world_from_station.Inverse() * beside_first.world_from_station;
  const auto judge = [](const HallStation& source, const RigidTransform& truth,
                        FineResult::Status status) {
    return Judge(source, *first_, truth, 40, {}, status);
  };
  using Status = FineResult::Status;
  const VerificationResult held = judge(beside_first, beside, Status::kRefinedOnSurfaces);
  EXPECT_EQ(held.verdict, Verdict::kDoubtful);
  EXPECT_EQ(held.reason, VerificationResult::Reason::kUndetermined);
  EXPECT_NEAR(held.apart_m, 0.5, 1e-6);
  EXPECT_EQ(judge(beside_first, beside, Status::kWeak).verdict, Verdict::kDoubtful)
      << "planes' own noise follows the beams, too";
  EXPECT_EQ(judge(beside_first, beside, Status::kTooFewPlanes).verdict, Verdict::kDoubtful)
      << "key points follow the beams, too";
  EXPECT_EQ(judge(beside_first, beside, Status::kRefined).verdict, Verdict::kAccepted)
      << "planes hold it";
  EXPECT_EQ(judge(*second_, Truth(), Status::kRefinedOnSurfaces).verdict, Verdict::kAccepted)
      << "beams from elsewhere fall elsewhere";
}

/// A pair that was refined from `start` to `end`.
class FarFromStart : public Verification {
 protected:
  static VerificationResult JudgeMove(const RigidTransform& start, const RigidTransform& end,
                                      std::optional<int> consensus,
                                      const VerificationOptions& options = {}) {
    FineResult fine;
    fine.status = FineResult::Status::kRefined;
    fine.target_from_source = end;
    fine.weakest_sigma_m = 0.001;
    Matrix6d information = Matrix6d::Identity();
    information *= 1e6;
    return VerifyPair({second_->surface(), first_->surface(), second_->index, first_->index, start,
                       information, consensus, 4, fine, std::nullopt},
                      options);
  }
  static RigidTransform Shifted(double shift_m) {
    RigidTransform motion = Truth();
    motion.translation.x() += shift_m;
    return motion;
  }
  /// About the source's scanner.
  static RigidTransform Turned(double turn_deg) {
    RigidTransform motion = Truth();
    motion.rotation = motion.rotation * ExpSo3(Eigen::Vector3d(0.0, 0.0, turn_deg * kDeg));
    return motion;
  }
};

constexpr int kByChance = 7;
constexpr int kSignificant = 40;

TEST_F(FarFromStart, IsDoubtedWhereTheStartCounts) {
  for (const std::optional<int> consensus : {std::optional<int>(kSignificant), {}}) {
    EXPECT_EQ(JudgeMove(Shifted(0.35), Truth(), consensus).verdict, Verdict::kAccepted);
    EXPECT_EQ(JudgeMove(Turned(0.8), Truth(), consensus).verdict, Verdict::kAccepted);
    const VerificationResult shifted = JudgeMove(Shifted(0.45), Truth(), consensus);
    EXPECT_NEAR(shifted.shift_l, 4.5, 1e-6);
    for (const VerificationResult& result : {shifted, JudgeMove(Turned(1.2), Truth(), consensus)}) {
      EXPECT_EQ(result.verdict, Verdict::kDoubtful);
      EXPECT_EQ(result.reason, VerificationResult::Reason::kFarFromStart);
    }
  }
}

TEST_F(FarFromStart, IsAcceptedWhereChanceProposedTheStartAndTheCloudsRefuteIt) {
  EXPECT_EQ(JudgeMove(Shifted(0.45), Truth(), kByChance).verdict, Verdict::kAccepted);
  EXPECT_EQ(JudgeMove(Turned(1.2), Truth(), kByChance).verdict, Verdict::kAccepted);
}

TEST_F(FarFromStart, IsDoubtedWhereTheStartFitsNoWorse) {
  // Options that let the clouds prove anything.
  const VerificationOptions options{.sure_quality = 0.0, .sure_conflict = 1.0, .max_conflict = 1.0};
  for (const RigidTransform& wrong : {Shifted(0.45), Turned(1.2)}) {
    const VerificationResult result = JudgeMove(Truth(), wrong, kByChance, options);
    EXPECT_EQ(result.verdict, Verdict::kDoubtful);
    EXPECT_EQ(result.reason, VerificationResult::Reason::kFarFromStart);
  }
  EXPECT_NE(JudgeMove(Truth(), Shifted(0.45), kByChance).verdict, Verdict::kAccepted);
}

TEST_F(Verification, RejectsLevelledStationsAtAnAngle) {
  FineResult fine;
  fine.status = FineResult::Status::kRefined;
  Vector6d tilt = Vector6d::Zero();
  tilt[0] = 0.5 * kDeg;
  fine.target_from_source = Retract(Truth(), tilt);
  Matrix6d information = Matrix6d::Identity();
  const auto judge = [&](std::optional<double> level_sigma) {
    return VerifyPair({second_->surface(), first_->surface(), second_->index, first_->index,
                       fine.target_from_source, information, 40, 4, fine, level_sigma},
                      {})
        .reason;
  };
  EXPECT_EQ(judge(0.01 * kDeg), VerificationResult::Reason::kTilted);
  EXPECT_NE(judge(std::nullopt), VerificationResult::Reason::kTilted);
}

TEST_F(Verification, DoesNotAskAScannerThatIsNotCredible) {
  Surface source = second_->surface();
  Surface target = first_->surface();
  source.scanner_credible = target.scanner_credible = false;
  const RigidTransform turned = HalfTurned();
  EXPECT_EQ(CompareClouds(source, second_->index.sample, target, first_->index, turned, 0.03)
                .conflict.value,
            0.0);
}

/// People walk about between the scans: no more than a few blocks are seen through.
TEST(FreeSpace, IsNotDecidedByPeople) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const HallScene scene(seed, {.boxes = 8});
    const HallScene busy = scene.WithPeople(seed + 100, 5);
    const HallScene busy_later = scene.WithPeople(seed + 200, 5);
    const HallStation a(busy, {-6.0, -3.0, 1.6}, seed);
    const HallStation b(busy_later, {3.0, 2.0, 1.7}, seed + 1);
    const RigidTransform truth = a.world_from_station.Inverse() * b.world_from_station;
    const VerificationResult result = Judge(b, a, truth);
    EXPECT_EQ(result.verdict, Verdict::kAccepted)
        << "seed " << seed << " conflict " << result.worst_conflict();
  }
}

TEST(FreeSpace, KnowsHiddenFromSeenThrough) {
  // A wall at x = 10 with a gap beside it, another behind at x = 16.
  std::vector<Eigen::Vector3d> points;
  for (double y = -8.0; y <= 8.0; y += 0.04) {
    for (double z = -1.0; z <= 1.0; z += 0.04) {
      if (y < 0.0) points.emplace_back(10.02, y, z);
      if (y > 0.0) points.emplace_back(16.02, 1.6 * y, 1.6 * z);
    }
  }
  const StationModel model = MakeSeenStation(points, 0.1);
  const Eigen::Vector3f facing(-1.0F, 0.0F, 0.0F);
  EXPECT_EQ(LookAt(model, {10.0, -4.0, 0.0}, facing), Sight::kAgrees);
  EXPECT_EQ(LookAt(model, {14.0, -4.0, 0.0}, facing), Sight::kHidden);
  EXPECT_EQ(LookAt(model, {10.0, 4.0, 0.0}, facing), Sight::kSeenThrough);
  EXPECT_EQ(LookAt(model, {16.0, 4.0, 0.0}, facing), Sight::kAgrees);
  EXPECT_EQ(LookAt(model, {-5.0, 0.0, 0.0}, facing), Sight::kNotInView);
}

/// Rolling ground that a scanner 1.6 m above it sees at a grazing angle, with beams 0.8 degrees
/// apart: its rings of points lie farther apart than a window of the image is wide.
double GroundHeight(double x, double y) {
  return -1.6 + 0.2 * std::sin(x / 7.0) * std::cos(y / 5.0) - 0.2 * std::sin(0.3) * std::cos(0.2);
}

TEST(FreeSpace, GroundBetweenFarBeamsIsNotSeenThrough) {
  constexpr double kStep = 0.8 * 0.017453292519943295;
  StationModel model;
  model.leaves = VoxelLeaves({.edge_m = 0.3});
  model.range_image = RangeImage(Eigen::Vector3d::Zero(), 0.45);
  for (double azimuth = 0.0; azimuth < 6.28; azimuth += kStep) {
    for (double elevation = -0.7; elevation < -0.01; elevation += kStep) {
      const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = 0.5;
      while (range < 60.0 && range * beam.z() > GroundHeight(range * beam.x(), range * beam.y())) {
        range += 0.01;
      }
      if (range < 60.0) model.range_image.Add(range * beam);
    }
  }
  const Eigen::Vector3f up(0.0F, 0.0F, 1.0F);
  int in_view = 0;
  int seen_through = 0;
  int raised_seen_through = 0;
  for (double x = -36.0; x <= 36.0; x += 0.5) {
    for (double y = -36.0; y <= 36.0; y += 0.5) {
      const double range = std::hypot(x, y);
      if (range < 20.0 || range > 36.0) continue;
      const Eigen::Vector3d ground(x, y, GroundHeight(x, y));
      in_view += LookAt(model, ground, up) != Sight::kNotInView ? 1 : 0;
      seen_through += LookAt(model, ground, up) == Sight::kSeenThrough ? 1 : 0;
      // A wall across the same place is met by beams that went on.
      const Eigen::Vector3f facing = -Eigen::Vector3d(x, y, 0.0).normalized().cast<float>();
      const Eigen::Vector3d wall(0.5 * x, 0.5 * y, 0.5 * GroundHeight(x, y));
      raised_seen_through += LookAt(model, wall, facing) == Sight::kSeenThrough ? 1 : 0;
    }
  }
  ASSERT_GT(in_view, 5000);
  EXPECT_LT(seen_through, in_view / 500);
  EXPECT_GT(raised_seen_through, in_view / 2);
}

}  // namespace
}  // namespace backsight
