#include "stages/misplaced_scanners.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "core/random.h"

namespace backsight {
namespace {

using testing::Eq;
using testing::Optional;

constexpr double kResolution = 0.1;
constexpr double kContradiction = 0.025;
constexpr int kLost = 4;  // the last station, whom nothing places

/// Four stations in one component, a fifth in its own, and pairs of it with all of them.
class MisplacedScanners : public testing::TestWithParam<int> {
 protected:
  MisplacedScanners() {
    for (int s = 0; s <= kLost; ++s) {
      truth_.push_back({random_.Rotation(), 30.0 * random_.Rotation().col(0)});
    }
    for (int s = 0; s < kLost; ++s) views_.push_back(ViewOf(s, 0.08, 0.01));
  }

  /// The pair of the lost station with another; every second time the lost one is the target.
  MutualView ViewOf(int other, double by_lost, std::optional<double> by_other) const {
    const auto [o, lost] = std::pair(static_cast<std::size_t>(other), std::size_t{kLost});
    if (other % 2 == 0) {
      return {kLost, other, truth_[o].Inverse() * truth_[lost], by_lost, by_other};
    }
    return {other, kLost, truth_[lost].Inverse() * truth_[o], by_other, by_lost};
  }

  void Shift(std::size_t view, double distance_m) {
    views_[view].target_from_source.translation += distance_m * random_.Rotation().col(0);
  }

  std::optional<int> Find() const {
    return FindMisplacedScanner(views_, {truth_, component_, assumed_}, kContradiction,
                                kResolution);
  }

  Random random_{static_cast<std::uint64_t>(GetParam())};
  std::vector<RigidTransform> truth_;
  std::vector<int> component_ = {0, 0, 0, 0, 1};
  std::vector<char> assumed_ = {1, 1, 1, 1, 1};
  std::vector<MutualView> views_;
};

TEST_P(MisplacedScanners, AreFoundWhereOnlyTheirOwnViewsContradict) {
  EXPECT_THAT(Find(), Optional(kLost));
}

TEST_P(MisplacedScanners, AreNotThoseOfPlacedStations) {
  component_.back() = 0;
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, NeedThreeWaysThatLeadToOnePlace) {
  Shift(1, 3.0);
  EXPECT_THAT(Find(), Optional(kLost)) << "three ways are left";
  Shift(3, 3.0);
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, NeedWaysFromOneComponent) {
  component_ = {0, 0, 2, 2, 1};
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, AreNotThoseOfStationsThatOthersHold) {
  truth_.push_back({random_.Rotation(), Eigen::Vector3d::Zero()});
  component_ = {0, 0, 0, 0, 1, 1};
  assumed_.push_back(1);
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, AreNotThoseThatTheUserVouchesFor) {
  assumed_.back() = 0;
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, AreFoundOneByOneTheMostAgreedOnFirst) {
  truth_.push_back({random_.Rotation(), 30.0 * random_.Rotation().col(0)});
  component_.push_back(2);
  assumed_.push_back(1);
  for (int s = 1; s < kLost; ++s) {  // one less than of the other
    const auto other = static_cast<std::size_t>(s);
    views_.push_back({kLost + 1, s, truth_[other].Inverse() * truth_.back(), 0.19, 0.01});
  }
  EXPECT_THAT(Find(), Optional(kLost));
  component_[kLost] = 0;
  EXPECT_THAT(Find(), Optional(kLost + 1));
}

TEST_P(MisplacedScanners, AreBelievedWhereMostOfTheirViewsAgree) {
  for (int s = 0; s < 3; ++s) views_[static_cast<std::size_t>(s)] = ViewOf(s, 0.01, 0.01);
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, AreBelievedWhereOthersContradictHalfAsMuch) {
  for (int s = 0; s < kLost; ++s) views_[static_cast<std::size_t>(s)] = ViewOf(s, 0.19, 0.1);
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, NeedLessOfOthersWhereFewCanLook) {
  for (int s = 0; s < kLost; ++s) {
    views_[static_cast<std::size_t>(s)] =
        ViewOf(s, 0.08, s == 0 ? std::optional(0.05) : std::nullopt);
  }
  EXPECT_THAT(Find(), Optional(kLost));
  views_[0] = ViewOf(0, 0.08, 0.09);
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

TEST_P(MisplacedScanners, NeedNoOtherScanners) {
  for (int s = 0; s < kLost; ++s) views_[static_cast<std::size_t>(s)] = ViewOf(s, 0.08, {});
  EXPECT_THAT(Find(), Optional(kLost));
}

TEST_P(MisplacedScanners, AreNotThoseWhoSawTooLittle) {
  for (MutualView& view : views_) {
    view.seen_through_by_source.reset();
    view.seen_through_by_target.reset();
  }
  EXPECT_THAT(Find(), Eq(std::nullopt));
}

INSTANTIATE_TEST_SUITE_P(Seeds, MisplacedScanners, testing::Values(1, 2, 3));

TEST(MisplacedScanner, IsNobodysWithoutPairs) {
  EXPECT_THAT(FindMisplacedScanner({}, {}, kContradiction, kResolution), Eq(std::nullopt));
}

}  // namespace
}  // namespace backsight
