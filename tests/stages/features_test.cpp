#include "stages/features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/random.h"
#include "stages/fpfh.h"
#include "stages/leaf_grid.h"
#include "stages/normals.h"
#include "tests/support/feature_scene.h"
#include "tests/support/pcl_features.h"

namespace backsight {
namespace {

using ::testing::IsEmpty;

constexpr double kResolution = 0.1;

IssParameters PlainIss() {
  return {.salient_radius_m = 6.0 * kResolution, .non_max_radius_m = 4.0 * kResolution};
}

class FeaturesOfYard : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  StationModel model_ = MakeYardStation(GetParam(), 0.25);
  std::vector<Eigen::Vector3f> points_ = LeafPositions(model_);
  LeafGrid grid_{points_, 3.0 * kResolution};
  ExecutionContext context_{4};
};

std::vector<std::uint32_t> BruteForce(std::span<const Eigen::Vector3f> points, std::uint32_t query,
                                      double radius_m) {
  const auto squared_radius = static_cast<float>(radius_m * radius_m);
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f d = points[i] - points[query];
    if (d.x() * d.x() + d.y() * d.y() + d.z() * d.z() < squared_radius) found.push_back(i);
  }
  return found;
}

void ExpectExactNeighborhoods(std::span<const Eigen::Vector3f> points, double edge_m,
                              double radius_m) {
  const LeafGrid grid(points, edge_m);
  std::vector<std::uint32_t> leaves;
  for (std::uint32_t place = 0; place < grid.size(); ++place) {
    leaves.push_back(grid.LeafAt(place));
  }
  leaves.resize(leaves.size() + LeafGrid::kPadding);
  BallSearch search(grid, radius_m);
  std::vector<std::uint32_t> candidates;
  std::size_t visited = 0;
  for (std::size_t cell = 0; cell < grid.cell_count(); ++cell) {
    search.EnterCell(cell);
    search.Gather(leaves, 0U, &candidates);
    for (std::uint32_t place = grid.Cell(cell).begin; place < grid.Cell(cell).end; ++place) {
      std::vector<std::uint32_t> found;
      for (const std::uint32_t j : search.Around(place)) found.push_back(candidates[j]);
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, BruteForce(points, grid.LeafAt(place), radius_m));
      ++visited;
    }
  }
  EXPECT_EQ(visited, points.size());
}

TEST(LeafGrid, NeighborhoodsEqualBruteForce) {
  Random random(11);
  for (int round = 0; round < 4; ++round) {
    std::vector<Eigen::Vector3f> points;
    points.reserve(702);
    for (int i = 0; i < 700; ++i) {
      points.emplace_back(random.Uniform(-3.0, 3.0), random.Uniform(-2.0, 2.0),
                          random.Uniform(-0.5, 0.5));
    }
    points.push_back(points.front());             // two in one place
    points.emplace_back(900.0F, -900.0F, 80.0F);  // far from all others
    for (const double radius_m : {0.05, 0.3, 0.31, 1.1}) {
      ExpectExactNeighborhoods(points, 0.3, radius_m);
    }
  }
}

TEST(LeafGrid, NeighborhoodsOfALatticeEqualBruteForce) {
  std::vector<Eigen::Vector3f> points;  // distances of exactly the radius are common here
  for (int x = -6; x < 6; ++x) {
    for (int y = -6; y < 6; ++y) {
      for (int z = -1; z < 2; ++z) points.emplace_back(0.25 * x, 0.25 * y, 0.25 * z);
    }
  }
  for (const double radius_m : {0.25, 0.5, 0.75}) ExpectExactNeighborhoods(points, 0.25, radius_m);
}

/// The slab of every point; each must lie in one.
std::vector<std::size_t> SlabsOfPoints(const LeafGrid& grid,
                                       const std::vector<LeafGrid::Slab>& slabs) {
  std::vector<std::size_t> slab_of(grid.size(), slabs.size());
  for (std::size_t slab = 0; slab < slabs.size(); ++slab) {
    for (const LeafGrid::Range& cells : slabs[slab]) {
      EXPECT_LT(cells.begin, cells.end);
      for (std::uint32_t place = grid.Cell(cells.begin).begin; place < grid.Cell(cells.end - 1).end;
           ++place) {
        std::size_t& its_slab = slab_of.at(grid.LeafAt(place));
        EXPECT_EQ(its_slab, slabs.size()) << "a point lies in two slabs";
        its_slab = slab;
      }
    }
  }
  EXPECT_EQ(std::count(slab_of.begin(), slab_of.end(), slabs.size()), 0) << "left out";
  return slab_of;
}

void ExpectGoodSlabs(std::span<const Eigen::Vector3f> points, double edge_m, double radius_m,
                     std::size_t least_points, std::size_t least_slabs) {
  const LeafGrid grid(points, edge_m);
  const auto slabs = grid.CutIntoSlabs(radius_m, least_points);
  EXPECT_GE(slabs.size(), least_slabs);
  const std::vector<std::size_t> slab_of = SlabsOfPoints(grid, slabs);
  for (std::size_t slab = 0; slab + 1 < slabs.size(); ++slab) {
    EXPECT_GE(std::count(slab_of.begin(), slab_of.end(), slab),
              static_cast<std::ptrdiff_t>(least_points));
  }
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (const std::uint32_t j : BruteForce(points, i, radius_m)) {
      EXPECT_LE(std::max(slab_of[i], slab_of[j]), std::min(slab_of[i], slab_of[j]) + 1);
    }
  }
}

TEST(LeafGrid, SlabsHoldAllPointsAndNeighborsInThoseBesideEachOther) {
  Random random(12);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(random.Uniform(-20.0, 20.0), random.Uniform(-6.0, 6.0),
                        random.Uniform(0.0, 1.0));
  }
  points.emplace_back(0.0F, 40.0F, 0.0F);  // beyond rows without points
  for (const double radius_m : {0.2, 0.6, 1.0}) {
    ExpectGoodSlabs(points, 0.3, radius_m, 1, 5);
    ExpectGoodSlabs(points, 0.3, radius_m, 200, 5);
  }
  ExpectGoodSlabs(points, 0.3, 100.0, 1, 1);
}

TEST(LeafGrid, SlabsOfALatticeHoldNeighborsInThoseBesideEachOther) {
  std::vector<Eigen::Vector3f> points;  // distances of exactly the radius are common here
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 60; ++y) points.emplace_back(0.25 * x, 0.125 * y, 0.0);
  }
  for (const double radius_m : {0.25, 0.5, 0.75}) ExpectGoodSlabs(points, 0.25, radius_m, 1, 8);
}

TEST(LeafGrid, SlabsOfAFewRowsAreOne) {
  EXPECT_THAT(LeafGrid({}, 0.3).CutIntoSlabs(0.6, 1), IsEmpty());
  ExpectGoodSlabs(std::vector<Eigen::Vector3f>{{0, 0, 0}, {40, 0.2F, 0}}, 0.3, 0.6, 1, 1);
}

TEST_P(FeaturesOfYard, NormalsEqualPclUpToSign) {
  const auto normals = EstimateNormals(grid_, 3.0 * kResolution, context_);
  const auto expected = PclNormals(points_, 3.0 * kResolution);
  ASSERT_EQ(normals.size(), expected.size());
  std::size_t compared = 0;
  std::size_t different = 0;
  for (std::uint32_t i = 0; i < normals.size(); ++i) {
    ASSERT_EQ(normals[i].allFinite(), expected[i].allFinite());
    if (!normals[i].allFinite()) continue;
    EXPECT_NEAR(normals[i].norm(), 1.0F, 1e-5F);
    // PCL works in float, which tells nothing where the two smallest eigenvalues are close.
    PointCluster cluster;
    for (const std::uint32_t j : BruteForce(points_, i, 3.0 * kResolution)) {
      cluster += {1.0, points_[j].cast<double>(), Eigen::Matrix3d::Zero()};
    }
    const Eigen::Vector3d e =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(cluster.scatter).eigenvalues();
    if (e[1] - e[0] < 0.02 * e[2]) continue;
    ++compared;
    if (normals[i].cross(expected[i]).norm() > 1e-3F) ++different;
  }
  EXPECT_GT(compared, normals.size() * 9 / 10);
  EXPECT_EQ(different, 0U);
}

TEST_P(FeaturesOfYard, KeypointsEqualPcl) {
  for (const double radius : {4.0, 3.0, 1.5}) {
    for (const int min_neighbors : {4, 12}) {
      IssParameters parameters = PlainIss();
      parameters.non_max_radius_m = radius * kResolution;
      parameters.min_neighbors = min_neighbors;
      const auto expected = PclIssKeypoints(points_, parameters);
      EXPECT_TRUE(!expected.empty() || min_neighbors > 4);
      EXPECT_EQ(FindIssKeypoints(grid_, parameters, context_), expected);
    }
  }
}

TEST_P(FeaturesOfYard, DescriptorsEqualPcl) {
  auto normals = EstimateNormals(grid_, 3.0 * kResolution, context_);
  for (std::size_t i = 0; i < normals.size(); i += 17) {
    normals[i].setConstant(std::numeric_limits<float>::quiet_NaN());  // leaves without one
  }
  const auto keypoints = FindIssKeypoints(grid_, PlainIss(), context_);
  const auto ours = ComputeFpfh(grid_, normals, keypoints, 8.0 * kResolution, context_);
  const auto expected = PclFpfh(points_, normals, keypoints, 8.0 * kResolution);
  ASSERT_EQ(ours.size(), expected.size());
  EXPECT_LT(MedianRelativeDifference(ours, expected), 1e-4);
}

/// The points turned about the origin and thinned at random, to a tenth at the far end of x.
std::vector<Eigen::Vector3f> TurnedAndThinned(std::span<const Eigen::Vector3f> points,
                                              Random* random) {
  const Eigen::Matrix3d rotation = random->Rotation();
  float min = 0.0F;
  float max = 0.0F;
  for (const Eigen::Vector3f& p : points) {
    min = std::min(min, p.x());
    max = std::max(max, p.x());
  }
  std::vector<Eigen::Vector3f> result;
  for (const Eigen::Vector3f& p : points) {
    const double share = 1.0 - 0.9 * (p.x() - min) / (max - min);
    if (random->Uniform() < share) result.push_back((rotation * p.cast<double>()).cast<float>());
  }
  return result;
}

TEST_P(FeaturesOfYard, TurnedAndThinnedEqualPcl) {
  Random random(GetParam());
  for (int round = 0; round < 3; ++round) {
    const std::vector<Eigen::Vector3f> points = TurnedAndThinned(points_, &random);
    const LeafGrid grid(points, 3.0 * kResolution);
    const auto keypoints = FindIssKeypoints(grid, PlainIss(), context_);
    EXPECT_FALSE(keypoints.empty());
    EXPECT_EQ(keypoints, PclIssKeypoints(points, PlainIss()));
    const auto normals = EstimateNormals(grid, 3.0 * kResolution, context_);
    const auto ours = ComputeFpfh(grid, normals, keypoints, 8.0 * kResolution, context_);
    const auto expected = PclFpfh(points, normals, keypoints, 8.0 * kResolution);
    EXPECT_LT(MedianRelativeDifference(ours, expected), 1e-4);
  }
}

TEST(Iss, KeypointsOfNearlyStraightLinesEqualPcl) {
  Random random(21);
  std::vector<Eigen::Vector3f> points;  // scan lines so far apart that neighbours are in line
  for (int line = 0; line < 40; ++line) {
    for (int i = 0; i < 200; ++i) {
      points.emplace_back(line + 1e-5 * random.Normal(), 0.08 * i + 0.01 * random.Normal(),
                          1e-3 * random.Normal());
    }
  }
  const auto expected = PclIssKeypoints(points, PlainIss());
  EXPECT_GT(expected.size(), 200U);
  EXPECT_EQ(FindIssKeypoints(LeafGrid(points, 0.3), PlainIss(), ExecutionContext(1)), expected);
}

TEST_P(FeaturesOfYard, BlocksOfDescriptorsSumTo100) {
  const StationFeatures features = ComputeFeatures(model_, {}, context_);
  ASSERT_EQ(features.keypoints.size(), features.descriptors.size());
  ASSERT_FALSE(features.keypoints.empty());
  EXPECT_TRUE(std::is_sorted(features.keypoints.begin(), features.keypoints.end()));
  for (const FpfhDescriptor& descriptor : features.descriptors) {
    for (std::size_t block = 0; block < 3; ++block) {
      float sum = 0.0F;
      for (std::size_t bin = 0; bin < 11; ++bin) sum += descriptor[11 * block + bin];
      EXPECT_NEAR(sum, 100.0F, 1e-3F);
    }
  }
}

TEST_P(FeaturesOfYard, SuppressionAdaptsToTheWantedNumber) {
  std::vector<std::vector<std::uint32_t>> tries;
  for (const double share : {1.0, 0.75, 0.5, 0.375}) {
    IssParameters parameters = PlainIss();
    parameters.non_max_radius_m *= share;
    tries.push_back(FindIssKeypoints(grid_, parameters, context_));
  }
  ASSERT_LT(tries[0].size(), tries[1].size());
  ASSERT_LT(tries[1].size(), tries[2].size());
  ASSERT_LT(tries[2].size(), tries[3].size());
  IssParameters parameters = PlainIss();
  for (std::size_t t = 0; t < tries.size(); ++t) {
    parameters.keypoints = static_cast<int>(tries[t].size());
    EXPECT_EQ(FindIssKeypoints(grid_, parameters, context_), tries[t]);
    ++parameters.keypoints;  // one more than this radius gives
    EXPECT_EQ(FindIssKeypoints(grid_, parameters, context_),
              tries[std::min(t + 1, tries.size() - 1)]);
  }
}

TEST_P(FeaturesOfYard, DoNotDependOnTheNumberOfThreads) {
  // The narrowest living context limits all; that of one thread must be gone before the other runs.
  const StationFeatures one = ComputeFeatures(model_, {}, ExecutionContext(1));
  ASSERT_EQ(context_.threads(), 4);
  const StationFeatures four = ComputeFeatures(model_, {}, context_);
  const auto same_bytes = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  EXPECT_TRUE(same_bytes(one.normals, four.normals));
  EXPECT_TRUE(same_bytes(one.keypoints, four.keypoints));
  EXPECT_TRUE(same_bytes(one.descriptors, four.descriptors));
  EXPECT_EQ(one.scanner_credible, four.scanner_credible);
}

TEST_P(FeaturesOfYard, DescriptorsDoNotDependOnSlabs) {
  const auto normals = EstimateNormals(grid_, 3.0 * kResolution, context_);
  const auto keypoints = FindIssKeypoints(grid_, PlainIss(), context_);
  const auto whole =
      ComputeFpfh(grid_, normals, keypoints, 8.0 * kResolution, context_, points_.size());
  ASSERT_GT(whole.size(), 20U);
  for (const std::size_t slab_points : {std::size_t{1}, points_.size() / 10}) {
    EXPECT_GE(grid_.CutIntoSlabs(8.0 * kResolution, slab_points).size(), 5U);
    const auto in_slabs =
        ComputeFpfh(grid_, normals, keypoints, 8.0 * kResolution, context_, slab_points);
    ASSERT_EQ(in_slabs.size(), whole.size());
    EXPECT_EQ(std::memcmp(in_slabs.data(), whole.data(), whole.size() * sizeof(whole[0])), 0);
  }
}

/// Moves the voxels' means, so that index i is the same piece of surface; two may share a voxel.
StationModel Moved(StationModel model, const Eigen::Matrix3d& rotation,
                   const Eigen::Vector3d& translation) {
  const VoxelLeaves leaves = std::exchange(model.leaves, VoxelLeaves(model.lattice()));
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const PointCluster cluster = Transformed(rotation, translation, leaves.Cluster(i));
    model.leaves.Add(model.lattice().Key(cluster.mean), cluster);
  }
  return model;
}

TEST_P(FeaturesOfYard, DoNotDependOnRotation) {
  Random random(GetParam());
  const StationFeatures before = ComputeFeatures(model_, {}, context_);
  const StationFeatures after =
      ComputeFeatures(Moved(model_, random.Rotation(), Eigen::Vector3d::Zero()), {}, context_);
  std::vector<FpfhDescriptor> a, b;
  std::size_t j = 0;
  for (std::size_t i = 0; i < before.keypoints.size(); ++i) {
    while (j < after.keypoints.size() && after.keypoints[j] < before.keypoints[i]) ++j;
    if (j == after.keypoints.size() || after.keypoints[j] != before.keypoints[i]) continue;
    a.push_back(before.descriptors[i]);
    b.push_back(after.descriptors[j]);
  }
  EXPECT_GT(a.size(), before.keypoints.size() * 98 / 100);
  EXPECT_LT(MedianRelativeDifference(a, b), 5e-3);
}

TEST_P(FeaturesOfYard, KnowAScanThatIsNotInItsScannersFrame) {
  const StationFeatures before = ComputeFeatures(model_, {}, context_);
  const StationFeatures after =
      ComputeFeatures(Moved(model_, Eigen::Matrix3d::Identity(), {40.0, 25.0, 0.0}), {}, context_);
  EXPECT_TRUE(before.scanner_credible);
  EXPECT_FALSE(after.scanner_credible);
  std::size_t alike = 0;
  std::size_t defined = 0;
  for (std::size_t i = 0; i < before.normals.size(); ++i) {
    if (!before.normals[i].allFinite() || !after.normals[i].allFinite()) continue;
    ++defined;
    if (before.normals[i].dot(after.normals[i]) > 0.0F) ++alike;
  }
  EXPECT_GT(alike, defined * 8 / 10);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FeaturesOfYard, ::testing::Values(1, 2, 3));

TEST(Features, OfNothingAreNone) {
  const StationFeatures features =
      ComputeFeatures(MakeStation({}, kResolution), {}, ExecutionContext(1));
  EXPECT_THAT(features.normals, IsEmpty());
  EXPECT_THAT(features.keypoints, IsEmpty());
  EXPECT_THAT(features.descriptors, IsEmpty());
}

TEST(Features, OfPointsWithoutNeighborsAreNoKeypoints) {
  std::vector<Eigen::Vector3d> points = {{2.0, 0.0, 0.0}};
  for (const int more : {0, 1, 30}) {
    for (int i = 0; i < more; ++i) points.emplace_back(3.0 + 2.0 * i, 5.0, 0.3 * i);
    const auto model = MakeStation(points, kResolution);
    const StationFeatures features = ComputeFeatures(model, {}, ExecutionContext(1));
    ASSERT_EQ(features.normals.size(), model.leaves.size());
    for (const Eigen::Vector3f& normal : features.normals) EXPECT_TRUE(normal.hasNaN());
    EXPECT_THAT(features.keypoints, IsEmpty());
    EXPECT_THAT(features.descriptors, IsEmpty());
  }
}

TEST(Features, DescriptorWithoutNeighborsIsNaN) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {5, 0, 0}, {5.1F, 0, 0}};
  const std::vector<Eigen::Vector3f> normals(3, Eigen::Vector3f::UnitZ());
  const LeafGrid grid(points, 0.3);
  const std::vector<std::uint32_t> keypoints = {0, 1};
  const auto descriptors = ComputeFpfh(grid, normals, keypoints, 0.8, ExecutionContext(1));
  EXPECT_TRUE(std::all_of(descriptors[0].begin(), descriptors[0].end(),
                          [](float value) { return std::isnan(value); }));
  for (const std::size_t middle : {5U, 16U, 27U}) EXPECT_EQ(descriptors[1][middle], 100.0F);
}

TEST(Features, DescriptorsOfCrowdsEqualPcl) {
  Random random(31);
  std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {0.9F, 0.1F, 0}, {0.9F, -0.1F, 0.1F}};
  for (int i = 0; i < 100000; ++i) {  // about the two, and out of the first one's reach
    points.emplace_back(random.Uniform(1.1, 1.6), random.Uniform(-0.2, 0.2),
                        random.Uniform(-0.05, 0.05));
  }
  std::vector<Eigen::Vector3f> normals;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d normal(0.2 * random.Normal(), 0.2 * random.Normal(), 1.0);
    normals.push_back(normal.normalized().cast<float>());
  }
  const std::vector<std::uint32_t> keypoints = {0};
  const auto ours =
      ComputeFpfh(LeafGrid(points, 0.5), normals, keypoints, 1.0, ExecutionContext(2)).at(0);
  const auto expected = PclFpfh(points, normals, keypoints, 1.0).at(0);
  for (std::size_t b = 0; b < ours.size(); ++b) EXPECT_NEAR(ours[b], expected[b], 0.02) << b;
  EXPECT_GT(*std::max_element(ours.begin(), ours.end()), 66.0F);  // more than 16 bits count
}

}  // namespace
}  // namespace backsight
