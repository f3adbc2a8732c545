#include "pipeline/checked_scanners.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "core/fingerprint.h"
#include "tests/io/scan_files.h"
#include "tests/pipeline/hall_stations.h"

namespace backsight {
namespace {

using testing::HasSubstr;

constexpr std::size_t kMoved = 4;

/// Five stations in a hall. The last one's scan was moved to other coordinates, whose origin lies
/// outside: from there its scanner would have looked through a wall.
HallStations MakeHall(std::uint64_t seed) {
  const HallScene scene(seed, {.boxes = 30});
  const std::vector<Eigen::Vector3d> places = {
      {-6.0, -2.0, 1.6}, {0.1, 0.2, 1.7}, {6.0, 2.5, 1.6}, {-0.5, -3.0, 1.8}, {0.6, 2.0, 1.6}};
  HallStations hall(scene, places, seed);
  Station& moved = hall.stations[kMoved];
  const Eigen::Vector3d elsewhere =
      hall.world_from_station[kMoved].rotation.transpose() * Eigen::Vector3d(-12.0, 1.0, 0.0);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& mean : moved.model.leaves.means()) points.push_back(mean - elsewhere);
  moved.model = MakeSeenStation(points, moved.model.resolution_m());
  moved.features = ComputeFeatures(moved.model, {}, ExecutionContext(1));
  moved.features.scanner_credible = true;  // as where surfaces happen to face that place
  moved.index = std::make_shared<const CloudIndex>(moved.model);
  hall.world_from_station[kMoved].translation +=
      hall.world_from_station[kMoved].rotation * elsewhere;
  for (Station& station : hall.stations) {
    station.record.extent_m = 15.0;
    station.digest = FingerprintText(station.spec.id + std::to_string(seed));
  }
  return hall;
}

/// The hall is convex: few of its surfaces stand between the moved origin and others.
SurveyOptions Strict() {
  SurveyOptions options;
  options.verification.sure_conflict = 0.004;
  return options;
}

class CheckedScanners : public testing::Test {
 protected:
  explicit CheckedScanners(std::uint64_t seed = 1) : hall_(MakeHall(seed)) {}

  HallStations hall_;
  SurveyOptions options_ = Strict();
  ExecutionContext context_{2};
  TempDir work_;
  ArtifactStore store_ = ArtifactStore(work_.path());

  std::map<std::string, std::filesystem::file_time_type> Stored() const {
    std::map<std::string, std::filesystem::file_time_type> stored;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(work_.path())) {
      if (entry.is_regular_file()) stored[entry.path().string()] = entry.last_write_time();
    }
    return stored;
  }

  PairDiscovery Discover(HallStations* hall) {
    return DiscoverWithCheckedScanners(PairUnits(hall->stations, options_, context_, store_), {},
                                       {}, &hall->stations);
  }

  static std::size_t Accepted(const PairDiscovery& discovery, std::size_t station) {
    return static_cast<std::size_t>(
        std::count_if(discovery.pairs.begin(), discovery.pairs.end(), [&](const Pair& pair) {
          return pair.accepted() && (static_cast<std::size_t>(pair.source) == station ||
                                     static_cast<std::size_t>(pair.target) == station);
        }));
  }
};

class CheckedScannersOfHalls : public CheckedScanners, public testing::WithParamInterface<int> {
 protected:
  CheckedScannersOfHalls() : CheckedScanners(static_cast<std::uint64_t>(GetParam())) {}
};

TEST_P(CheckedScannersOfHalls, PlaceAStationWhoseScannerStoodElsewhere) {
  const ArtifactStore nothing;
  const PairUnits units(hall_.stations, options_, context_, nothing);
  EXPECT_EQ(Accepted(DiscoverPairs(units, {}), kMoved), 0U) << "its scanner contradicts all pairs";
  const PairDiscovery discovery = Discover(&hall_);
  EXPECT_GE(Accepted(discovery, kMoved), 3U);
  for (const Pair& pair : discovery.pairs) {
    if (!pair.accepted()) continue;
    const RigidTransform truth = hall_.Truth(pair.source, pair.target);
    EXPECT_LT((truth.translation - pair.best()->fine.target_from_source.translation).norm(), 0.02);
  }
  ASSERT_EQ(hall_.stations[kMoved].model.scanner_place, ScannerPlace::kUnknown);
  EXPECT_THAT(hall_.stations[kMoved].record.notes.back(), HasSubstr("give scanner_origin_m"));
  for (std::size_t s = 0; s < kMoved; ++s) {
    EXPECT_EQ(hall_.stations[s].model.scanner_place, ScannerPlace::kAssumed);
  }
}

TEST_F(CheckedScanners, AreRememberedByTheNextRun) {
  HallStations again = hall_;
  const PairDiscovery first = Discover(&hall_);
  const auto stored = Stored();
  const PairDiscovery second = Discover(&again);
  EXPECT_EQ(Stored(), stored) << "nothing is computed again";
  EXPECT_EQ(again.stations[kMoved].model.scanner_place, ScannerPlace::kUnknown);
  ASSERT_EQ(first.pairs.size(), second.pairs.size());
  for (std::size_t p = 0; p < first.pairs.size(); ++p) {
    EXPECT_EQ(first.pairs[p].digest, second.pairs[p].digest);
  }
}

TEST_F(CheckedScanners, TakeOverEarlyPairsButThoseOfTheForgottenStation) {
  HallStations again = hall_;
  Discover(&hall_);  // stores which one that is
  RegisteredPairs early;
  for (const int source : {1, static_cast<int>(kMoved)}) {
    Pair pair;
    pair.source = source;
    pair.target = 0;
    pair.further_fault = "early";
    early.emplace(std::pair(source, 0), pair);
  }
  const PairDiscovery found = DiscoverWithCheckedScanners(
      PairUnits(again.stations, options_, context_, store_), {}, std::move(early), &again.stations);
  ASSERT_EQ(again.stations[kMoved].model.scanner_place, ScannerPlace::kUnknown);
  for (const Pair& pair : found.pairs) {
    EXPECT_EQ(pair.further_fault == "early", pair.source == 1 && pair.target == 0);
  }
}

TEST_F(CheckedScanners, BelieveTheUser) {
  hall_.stations[kMoved].model.scanner_place = ScannerPlace::kGiven;
  const PairDiscovery discovery = Discover(&hall_);
  EXPECT_EQ(Accepted(discovery, kMoved), 0U);
  EXPECT_EQ(hall_.stations[kMoved].model.scanner_place, ScannerPlace::kGiven);
}

INSTANTIATE_TEST_SUITE_P(Seeds, CheckedScannersOfHalls, testing::Values(1, 2));

}  // namespace
}  // namespace backsight
