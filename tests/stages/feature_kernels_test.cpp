#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/random.h"
#include "graph/symmetric_eigen.h"
#include "stages/features.h"
#include "stages/leaf_grid.h"
#include "stages/neighborhood_moments.h"
#include "stages/pair_histogram.h"
#include "tests/support/feature_scene.h"
#include "tests/support/instruction_sets.h"

// Every kernel on every instruction set of this machine, the scalar one among them.

namespace backsight {
namespace {

class FeatureKernels : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { BindKernels(GetParam()); }
  void TearDown() override { BindKernels(0); }
};

/// Oriented points within a cube of 2 m, padded by points far away.
struct OrientedCloud {
  OrientedCloud(std::size_t n, Random* random) {
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d normal = random->Rotation().col(0);
      Add({Coordinate(random), Coordinate(random), Coordinate(random),
           static_cast<float>(normal.x()), static_cast<float>(normal.y()),
           static_cast<float>(normal.z())});
    }
  }

  void Add(const OrientedPoint& p) {
    points.push_back(p);
    const std::size_t padded = (points.size() + 15) / 16 * 16;
    for (auto& column : columns) column.resize(padded, LeafGrid::kFarAway);
    const float values[] = {p.x, p.y, p.z, p.nx, p.ny, p.nz};
    for (std::size_t c = 0; c < 6; ++c) columns[c][points.size() - 1] = values[c];
  }

  OrientedColumns Columns() const {
    return {columns[0].data(), columns[1].data(), columns[2].data(), columns[3].data(),
            columns[4].data(), columns[5].data(), columns[0].size()};
  }
  CandidateColumns Candidates() const {
    return {columns[0].data(), columns[1].data(), columns[2].data(), columns[0].size()};
  }

  static float Coordinate(Random* random) { return static_cast<float>(random->Uniform(-1.0, 1.0)); }

  std::vector<OrientedPoint> points;
  std::vector<float> columns[6];
};

float SquaredDistance(const OrientedPoint& a, const Coordinates& b) {
  const float dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
  return dx * dx + dy * dy + dz * dz;
}

int Bin(double share) { return std::clamp(static_cast<int>(std::floor(11.0 * share)), 0, 10); }

/// The definition, with angles.
void CountPair(const OrientedPoint& p, const OrientedPoint& q, PairHistogram* histogram) {
  const Eigen::Vector3d np(p.nx, p.ny, p.nz), nq(q.nx, q.ny, q.nz);
  Eigen::Vector3d d = Eigen::Vector3d(q.x, q.y, q.z) - Eigen::Vector3d(p.x, p.y, p.z);
  const bool swap = std::abs(np.dot(d)) < std::abs(nq.dot(d));
  const Eigen::Vector3d& u = swap ? nq : np;
  const Eigen::Vector3d& target = swap ? np : nq;
  if (swap) d = -d;
  const Eigen::Vector3d v = d.cross(u).normalized();
  const double f1 = std::atan2(u.cross(v).dot(target), u.dot(target));
  ++histogram->counts[Bin(0.5 + f1 / (2.0 * std::numbers::pi))];
  ++histogram->counts[11 + Bin(0.5 + 0.5 * v.dot(target))];
  ++histogram->counts[22 + Bin(0.5 + 0.5 * u.dot(d) / d.norm())];
}

std::uint32_t Difference(const PairHistogram& a, const PairHistogram& b) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 33; ++i) {
    sum += std::max(a.counts[i], b.counts[i]) - std::min(a.counts[i], b.counts[i]);
  }
  return sum;
}

TEST_P(FeatureKernels, PairsEqualTheDefinition) {
  Random random(3);
  std::uint32_t different = 0;
  for (const std::size_t n : {1U, 2U, 15U, 16U, 17U, 300U, 1024U, 1500U, 5000U}) {
    const OrientedCloud cloud(n, &random);
    const OrientedPoint& point = cloud.points[n / 2];
    PairHistogram expected;
    for (const OrientedPoint& other : cloud.points) {
      if (SquaredDistance(other, {point.x, point.y, point.z}) >= 1.0F) continue;
      ++expected.neighbors;
      if (&other != &point) CountPair(point, other, &expected);
    }
    const PairHistogram found = CountPairs(point, cloud.Columns(), 1.0F);
    EXPECT_EQ(found.neighbors, expected.neighbors);
    different += Difference(found, expected);
  }
  EXPECT_LE(different, 4U);  // some 10,000 angles; one on an edge counts twice
}

TEST_P(FeatureKernels, PairsWithoutAnglesAreNeighborsInNoBin) {
  Random random(4);
  OrientedCloud cloud(0, &random);
  const OrientedPoint point{0.5F, 0.25F, 0.0F, 0.0F, 0.0F, 1.0F};
  cloud.Add(point);
  cloud.Add({0.5F, 0.25F, 0.0F, 0.0F, 1.0F, 0.0F});  // in one place
  cloud.Add({0.5F, 0.25F, 0.5F, 0.0F, 0.0F, 1.0F});  // along the normal
  EXPECT_EQ(CountPairs(point, cloud.Columns(), 1.0F).neighbors, 3U);
  EXPECT_EQ(Difference(CountPairs(point, cloud.Columns(), 1.0F), {}), 0U);
  cloud.Add({0.75F, 0.25F, 0.0F, 0.0F, 0.0F, 1.0F});  // in the plane
  PairHistogram expected;
  for (const std::size_t middle : {5U, 16U, 27U}) expected.counts[middle] = 1;
  EXPECT_EQ(Difference(CountPairs(point, cloud.Columns(), 1.0F), expected), 0U);
}

TEST_P(FeatureKernels, PairsOfVeryManyPointsDoNotOverflow) {
  Random random(5);
  const OrientedCloud cloud(150000, &random);
  const PairHistogram all = CountPairs(cloud.points[7], cloud.Columns(), 100.0F);
  EXPECT_EQ(all.neighbors, 150000U);
  for (std::size_t block = 0; block < 3; ++block) {
    std::uint32_t sum = 0;
    for (std::size_t bin = 0; bin < 11; ++bin) sum += all.counts[11 * block + bin];
    EXPECT_EQ(sum, 149999U);
  }
}

TEST_P(FeatureKernels, MomentsEqualPlainSums) {
  Random random(6);
  for (const std::size_t n : {1U, 7U, 8U, 9U, 160U, 1030U, 4000U}) {
    const OrientedCloud cloud(n, &random);
    const Coordinates center{cloud.points[0].x, cloud.points[0].y, cloud.points[0].z};
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    std::uint32_t count = 0;
    for (const OrientedPoint& p : cloud.points) {
      if (SquaredDistance(p, center) >= 0.8F) continue;
      const Eigen::Vector3d d =
          Eigen::Vector3d(p.x, p.y, p.z) - Eigen::Vector3d(center.x, center.y, center.z);
      first += d;
      second += d * d.transpose();
      ++count;
    }
    const NeighborhoodMoments m = SumMoments(cloud.Candidates(), center, 0.8F);
    EXPECT_EQ(m.count, count);
    const double tolerance = 1e-13 * static_cast<double>(n);
    EXPECT_NEAR((Eigen::Vector3d(m.x, m.y, m.z) - first).norm(), 0.0, tolerance);
    Eigen::Matrix3d found;
    found << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
    EXPECT_NEAR((found - second).norm(), 0.0, tolerance);
  }
}

TEST_P(FeatureKernels, NearestGreaterEqualsBruteForce) {
  Random random(7);
  const OrientedCloud cloud(203, &random);
  std::vector<double> values(cloud.columns[0].size(), 0.0);
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    values[i] = std::floor(random.Uniform() * 9);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Coordinates center{cloud.points[i].x, cloud.points[i].y, cloud.points[i].z};
    float expected = std::numeric_limits<float>::max();
    for (std::size_t j = 0; j < cloud.points.size(); ++j) {
      if (values[j] > values[i]) {
        expected = std::min(expected, SquaredDistance(cloud.points[j], center));
      }
    }
    ASSERT_EQ(SquaredDistanceToGreater(cloud.Candidates(), values.data(), center, values[i]),
              expected);
  }
}

/// Of all shapes: round, flat, straight, and both to within rounding.
std::vector<Eigen::Matrix3d> SymmetricMatrices() {
  Random random(8);
  std::vector<Eigen::Matrix3d> matrices = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity()};
  for (const double middle : {1.0, 0.999999, 0.5, 1e-3, 1e-9, 0.0}) {
    for (const double low : {1.0, 0.999999, 0.5, 1e-4, 1e-11, 0.0}) {
      for (int round = 0; round < 6; ++round) {
        const Eigen::Matrix3d axes = round == 0 ? Eigen::Matrix3d::Identity() : random.Rotation();
        const Eigen::Vector3d e(7.0, 7.0 * middle, 7.0 * middle * low);
        const Eigen::Matrix3d matrix = axes * e.asDiagonal() * axes.transpose();
        matrices.push_back(0.5 * (matrix + matrix.transpose()));
      }
    }
  }
  return matrices;
}

TEST_P(FeatureKernels, EigenvaluesAndDirectionsEqualTheIterativeOnes) {
  const std::vector<Eigen::Matrix3d> matrices = SymmetricMatrices();
  SymmetricColumns columns;
  columns.Resize(matrices.size());
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    const Eigen::Matrix3d& m = matrices[i];
    columns.Set(i, {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)});
  }
  EigenvalueColumns found;
  FindEigenvalues(columns, &found);
  const std::vector<Eigen::Vector3d> directions = LeastDirections(columns);
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrices[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(found[k][i], solver.eigenvalues()[static_cast<Eigen::Index>(k)], 2e-14)
          << matrices[i];
    }
    EXPECT_NEAR(directions[i].norm(), 1.0, 1e-14) << matrices[i];
    const Eigen::Vector3d residual =
        matrices[i] * directions[i] - solver.eigenvalues()[0] * directions[i];
    EXPECT_LT(residual.norm(), 2e-14) << matrices[i];
  }
}

TEST_P(FeatureKernels, FeaturesAreTheSameBytesOnEveryInstructionSet) {
  const StationModel model = MakeYardStation(5, 0.25);
  const StationFeatures here = ComputeFeatures(model, {}, ExecutionContext(1));
  BindKernels(0);
  const StationFeatures best = ComputeFeatures(model, {}, ExecutionContext(1));
  const auto same_bytes = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  EXPECT_FALSE(best.keypoints.empty());
  EXPECT_TRUE(same_bytes(here.normals, best.normals));
  EXPECT_TRUE(same_bytes(here.keypoints, best.keypoints));
  EXPECT_TRUE(same_bytes(here.descriptors, best.descriptors));
}

INSTANTIATE_TEST_SUITE_P(Targets, FeatureKernels,
                         ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& test) { return std::string(hwy::TargetName(test.param)); });

}  // namespace
}  // namespace backsight
