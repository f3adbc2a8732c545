#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/random.h"
#include "pipeline/distance_records.h"
#include "pipeline/placed_clouds.h"
#include "pipeline/plan_pictures.h"
#include "pipeline/section_choice.h"
#include "pipeline/section_pictures.h"

namespace backsight {
namespace {

/// Voxels with 40 points each in the floor, every `edge_m` within the given sides.
Station Floor(double edge_m, double length_m, double width_m) {
  Station station;
  VoxelLeaves& leaves = station.model.leaves;
  leaves = VoxelLeaves({.edge_m = edge_m});
  for (double x = 0.0; x < length_m; x += edge_m) {
    for (double y = 0.0; y < width_m; y += edge_m) {
      const Eigen::Matrix3d scatter = Eigen::Vector3d(0.03, 0.03, 1e-6).asDiagonal();
      const Eigen::Vector3d mean(x + 0.25 * edge_m, y + 0.25 * edge_m, 0.0);
      leaves.Add(leaves.lattice().Key(mean), {40.0, mean, scatter});
    }
  }
  station.index = std::make_shared<CloudIndex>(station.model);
  return station;
}

PlacedClouds Place(const std::vector<Station>& stations) {
  PlacedClouds clouds;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    clouds.stations.push_back({&stations[s], s, {}});
  }
  return clouds;
}

TEST(DrawDensity, CountsPointsPerSquareMetreWhateverThePixel) {
  for (const double length_m : {30.0, 300.0}) {
    const std::vector<Station> stations = {Floor(0.1, length_m, 2.0)};
    const PlacedClouds clouds = Place(stations);
    const PictureRecord picture = DrawDensity(clouds, ExtentOf(clouds), {}, ExecutionContext(1));
    // All the same but for pixels half outside; then the scale ends at twice its beginning.
    const double densest = picture.scale->stops.back().value;
    EXPECT_GT(densest, 0.7 * 4000.0) << picture.metres_per_pixel;
    EXPECT_LT(densest, 2.1 * 4000.0) << picture.metres_per_pixel;
  }
}

/// On two walls that are turned by 17 degrees, and on the floor before them.
std::vector<DistanceSample> TurnedWalls(double apart_m) {
  Random random(9);
  const double turn = 17.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d along(std::cos(turn), std::sin(turn), 0.0);
  const Eigen::Vector3d across(-along.y(), along.x(), 0.0);
  std::vector<DistanceSample> samples;
  for (int i = 0; i < 4000; ++i) {
    const double u = random.Uniform(-8.0, 8.0), v = random.Uniform(0.0, 3.0);
    switch (i % 3) {
      case 0:
        samples.push_back(
            {5.0 * across + u * along + v * Eigen::Vector3d::UnitZ(), across, apart_m});
        break;
      case 1:
        samples.push_back(
            {8.0 * along + u * across + v * Eigen::Vector3d::UnitZ(), along, apart_m});
        break;
      default:
        samples.push_back({u * along + v * across, Eigen::Vector3d::UnitZ(), apart_m});
    }
  }
  return samples;
}

const CloudExtent kExtent{{-12.0, -10.0, 0.0}, {12.0, 10.0, 3.0}};

TEST(ChooseSections, LinesInPlanBeginWhereTheSectionsAxisIsZero) {
  const std::vector<NamedSection> sections = ChooseSections(kExtent, TurnedWalls(0.001));
  const std::vector<PictureLine> traces = TracesOf(sections);
  ASSERT_EQ(sections.size(), 4U);
  ASSERT_EQ(traces.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Section& section = sections[2 + i].section;
    const Eigen::Vector3d from(traces[i].from.x(), traces[i].from.y(), 0.0);
    const Eigen::Vector3d to(traces[i].to.x(), traces[i].to.y(), 0.0);
    EXPECT_NEAR(section.OnPaper(from).x(), 0.0, 1e-9);
    EXPECT_NEAR(section.OnPaper(to).x(), (to - from).norm(), 1e-9);
    // Along a wall, and from border to border.
    const double turn = std::atan2((to - from).y(), (to - from).x()) * 180.0 / std::numbers::pi;
    EXPECT_LT(std::abs(std::remainder(turn - 17.0, 90.0)), 2.0);
    for (const Eigen::Vector3d& end : {from, to}) {
      const double inside = std::min(12.0 - std::abs(end.x()), 10.0 - std::abs(end.y()));
      EXPECT_NEAR(inside, 0.0, 1e-9);
    }
  }
}

TEST(ChooseWorst, FindsTheDoubledWallAmongGoodOnes) {
  std::vector<DistanceSample> samples = TurnedWalls(0.001);
  EXPECT_NEAR(*ChooseWorst(kExtent, samples)->apart_m, 0.001, 1e-12);
  const Eigen::Vector3d place(3.2, -4.3, 1.2);
  for (int i = 0; i < 20; ++i) {
    samples.push_back(
        {place + Eigen::Vector3d(0.01 * i, 0.0, 0.0), Eigen::Vector3d::UnitY(), 0.02});
  }
  const auto wall = ChooseWorst(kExtent, samples);
  EXPECT_NEAR(*wall->apart_m, 0.02, 1e-12);
  EXPECT_FALSE(wall->upright);
  EXPECT_NEAR(wall->at_m, 1.2, 1e-9);
  EXPECT_NEAR((*wall->detail - place.head<2>()).norm(), 0.1, 0.01);
  // A sunken floor shows in an upright section, which has its line in plan.
  for (int i = 0; i < 20; ++i) {
    samples.push_back({{6.0 + 0.01 * i, 2.3, 0.0}, Eigen::Vector3d::UnitZ(), 0.03});
  }
  const auto floor = ChooseWorst(kExtent, samples);
  ASSERT_TRUE(floor->upright);
  const std::vector<PictureLine> trace = TracesOf({*floor});
  ASSERT_EQ(trace.size(), 1U);
  EXPECT_NEAR((trace[0].to - trace[0].from).norm(), kDetailM, 1e-9);
  // The floor around has its part in the middle.
  EXPECT_LT((0.5 * (trace[0].to + trace[0].from) - Eigen::Vector2d(6.095, 2.3)).norm(), 0.1);
  EXPECT_FALSE(ChooseWorst(kExtent, {}));
}

TEST(DrawSections, TellTenStationsApartAndCallTheRestOthers) {
  for (const std::size_t count : {std::size_t{10}, std::size_t{13}}) {
    std::vector<Station> stations;
    for (std::size_t s = 0; s < count; ++s) {
      stations.push_back(Floor(0.1, 2.0 + 0.5 * static_cast<double>(s), 1.0));
      stations.back().spec.id = "S" + std::to_string(s);
    }
    NamedSection level;
    level.section.thickness_m = kThicknessM;
    const std::vector<PictureRecord> pictures =
        DrawSections(Place(stations), {level}, ExecutionContext(1));
    ASSERT_EQ(pictures.size(), 1U);
    std::map<std::array<std::uint8_t, 3>, int> colours;
    for (const PictureKey& key : pictures[0].keys) ++colours[key.rgb];
    EXPECT_EQ(pictures[0].keys.size(), count == 10 ? 10U : 11U);
    EXPECT_EQ(colours.size(), pictures[0].keys.size());
    EXPECT_EQ(pictures[0].keys.back().label, count == 10 ? "S9" : "3 others");
  }
}

TEST(DrawSections, AreTheSameOnAnyThreadsInTheOrderOfTheSections) {
  const std::vector<Station> stations = {Floor(0.1, 4.0, 2.0), Floor(0.07, 3.0, 3.0)};
  const std::vector<DistanceSample> samples = TurnedWalls(0.001);
  std::vector<NamedSection> sections = ChooseSections(kExtent, samples);
  for (NamedSection& section : sections) section.section.thickness_m = 5.0;
  sections.push_back(*ChooseWorst(kExtent, samples));
  const auto once = DrawSections(Place(stations), sections, ExecutionContext(1));
  const auto again = DrawSections(Place(stations), sections, ExecutionContext(3));
  ASSERT_GE(once.size(), sections.size());
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].title, again[i].title);
    EXPECT_EQ(once[i].png_base64, again[i].png_base64);
  }
}

TEST(MiddleOf, EqualsThatOfSortedValues) {
  Random random(4);
  for (const std::size_t count : {1U, 2U, 99U, 100U, 101U, 5000U}) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(random.Normal());
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const auto [low, high] = MiddleOf(values);
    EXPECT_EQ(low, sorted[count / 100]);
    EXPECT_EQ(high, sorted[count - 1 - count / 100]);
  }
}

TEST(DeliveredPlace, IsOnTheGroundWhereControlPlacesTheComponentAndFitsUnscaled) {
  Network network;
  network.component = {0, 0, -1};
  network.survey_from_station.resize(3);
  network.survey_from_station[1].translation = {10.0, 0.0, 0.0};
  EXPECT_EQ(DeliveredPlace(network, {}, 1)->translation.x(), 10.0);
  EXPECT_FALSE(DeliveredPlace(network, {}, 2));
  GeoreferencedNetwork ground;
  ground.parts.resize(1);
  ground.parts[0].result.status = GeoreferencingResult::Status::kGeoreferenced;
  ground.parts[0].result.adjustment.scale = 1.001;
  ground.enu_from_station.resize(3);
  ground.enu_from_station[0] = RigidTransform();
  ground.enu_from_station[1] = RigidTransform();
  ground.enu_from_station[1]->translation = {0.0, 10.01, 0.0};
  EXPECT_NEAR((DeliveredPlace(network, ground, 1)->translation - Eigen::Vector3d(0, 10, 0)).norm(),
              0.0, 1e-12);
}

TEST(MakeDistanceRecord, CountsRanksAndBins) {
  std::vector<Station> stations(2);
  stations[0].spec.id = "A";
  stations[1].spec.id = "B";
  SurfaceDistances distances;
  distances.pairs.push_back({0, 1, {}});
  for (int i = 1; i <= 100; ++i) {
    distances.pairs[0].samples.push_back(
        {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 1e-4 * (101 - i)});
  }
  const DistanceRecord record = *MakeDistanceRecord(stations, distances);
  EXPECT_NEAR(record.total.median_m, 0.0050, 1e-12);
  EXPECT_NEAR(record.total.p68_m, 0.0068, 1e-12);
  EXPECT_NEAR(record.total.p95_m, 0.0095, 1e-12);
  std::uint64_t binned = record.beyond;
  for (std::size_t b = 0; b < record.bins.size(); ++b) {
    binned += record.bins[b];
    const double low = record.bin_m * static_cast<double>(b);
    int expected = 0;
    for (const DistanceSample& s : distances.pairs[0].samples) {
      expected += s.distance_m >= low && s.distance_m < low + record.bin_m ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(record.bins[b]), expected, 1.0) << b;  // edges, by rounding
  }
  EXPECT_EQ(binned, 100U);
  EXPECT_FALSE(MakeDistanceRecord(stations, {}));
}

}  // namespace
}  // namespace backsight
