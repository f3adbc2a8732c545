#include "stages/ingest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "core/voxel_grid.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDegree = std::numbers::pi / 180.0;

/// A box of 12 x 8 x 3 m seen from `scanner` in steps of a grid of angles, in one chunk.
class BoxScan : public ScanReader {
 public:
  BoxScan(const Eigen::Vector3d& scanner, double step_deg) {
    info_.path = "box";
    for (double polar = 20.0; polar < 150.0; polar += step_deg) {
      for (double azimuth = 0.0; azimuth < 360.0; azimuth += step_deg) {
        const double p = polar * kDegree;
        const double a = azimuth * kDegree;
        const Eigen::Array3d beam(std::sin(p) * std::cos(a), std::sin(p) * std::sin(a),
                                  std::cos(p));
        const Eigen::Array3d wall(6.0, 4.0, 1.5);
        const Eigen::Vector3d point = scanner + ((wall / beam.abs()).minCoeff() * beam).matrix();
        points_.x.push_back(point.x());
        points_.y.push_back(point.y());
        points_.z.push_back(point.z());
      }
    }
    tally_.records = tally_.points = points_.size();
  }
  const ScanInfo& info() const override { return info_; }
  bool Next(PointChunk& chunk) override {
    chunk = points_;
    points_.Clear();
    return chunk.size() > 0;
  }
  const ScanTally& tally() const override { return tally_; }

 private:
  PointChunk points_;
  ScanInfo info_;
  ScanTally tally_;
};

IngestResult Ingest(const Eigen::Vector3d& scanner, double step_deg) {
  BoxScan scan(scanner, step_deg);
  return IngestScan("S1", scan, scanner, IngestOptions{}, ExecutionContext{});
}

/// Some chunks of a hall's points, empty ones first.
class ChunkedScan : public ScanReader {
 public:
  explicit ChunkedScan(std::vector<PointChunk> chunks) : chunks_(std::move(chunks)) {
    info_.path = "chunks";
  }
  const ScanInfo& info() const override { return info_; }
  const ScanTally& tally() const override { return tally_; }
  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (next_ == chunks_.size()) return false;
    chunk = chunks_[next_++];
    return true;
  }

 private:
  std::vector<PointChunk> chunks_;
  std::size_t next_ = 0;
  ScanInfo info_;
  ScanTally tally_;
};

std::vector<PointChunk> HallChunks(const Eigen::Vector3d& center) {
  Random random(4);
  std::vector<PointChunk> chunks(2);
  for (int c = 0; c < 25; ++c) {
    PointChunk& chunk = chunks.emplace_back();
    for (std::uint64_t i = random.Index(3000); i > 0; --i) {
      const double far = random.Index(500) == 0 ? 400.0 : 1.0;
      chunk.x.push_back(center.x() + far * random.Uniform(-6, 6));
      chunk.y.push_back(center.y() + far * random.Uniform(-4, 4));
      chunk.z.push_back(center.z() + random.Uniform(-1, 2));
    }
  }
  return chunks;
}

TEST(Ingest, HasTheBitsOfOnePointAfterTheOtherForAnyThreads) {
  for (const Eigen::Vector3d& center : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5e5, 6e6, 80)}) {
    const std::vector<PointChunk> chunks = HallChunks(center);
    const Eigen::Vector3d first(chunks[2].x[0], chunks[2].y[0], chunks[2].z[0]);
    VoxelLattice lattice{.edge_m = 0.1};
    if (center.x() > 0.0) lattice.origin = first.array().round();
    VoxelClusterer clusterer(lattice);
    std::uint64_t points = 0;
    for (const PointChunk& chunk : chunks) {
      for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Eigen::Vector3d point(chunk.x[i], chunk.y[i], chunk.z[i]);
        const double range = (point - center).norm();
        if (range < 0.5 || range > 1000.0) continue;
        clusterer.Add(point);
        ++points;
      }
    }
    VoxelLeaves expected = clusterer.Finish();
    expected.Translate(-center);
    for (const int threads : {1, 2, 6}) {
      ChunkedScan scan(chunks);
      const IngestResult result =
          IngestScan("S1", scan, center, IngestOptions{}, ExecutionContext(threads));
      EXPECT_EQ(result.model.points, points);
      EXPECT_GT(result.out_of_range, 0U);
      ASSERT_EQ(result.model.leaves.size(), expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const PointCluster found = result.model.leaves.Cluster(i);
        ASSERT_EQ(result.model.leaves.Key(i), expected.Key(i));
        ASSERT_EQ(found.count, expected.Count(i));
        ASSERT_EQ(found.mean, expected.Mean(i));
        ASSERT_EQ(found.scatter, expected.Cluster(i).scatter);
      }
    }
  }
}

TEST(Ingest, PixelsAreAsWideAsTheBeamsAreApart) {
  for (const Eigen::Vector3d& scanner : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(700, -90, 3)}) {
    for (const double step : {0.5, 0.8, 1.3}) {
      const RangeImage image = Ingest(scanner, step).model.range_image;
      EXPECT_NEAR(image.PixelAngle(), step * kDegree, 0.05 * step * kDegree);
    }
  }
}

TEST(Ingest, PixelsOfDenseScansAreTheLeastOnes) {
  EXPECT_NEAR(Ingest(Eigen::Vector3d::Zero(), 0.15).model.range_image.PixelAngle(), 0.25 * kDegree,
              1e-9);
}

TEST(Ingest, LeavesAndRangesAreInTheInstrumentsFrame) {
  const Eigen::Vector3d scanner(700.0, -90.0, 3.0);
  const IngestResult result = Ingest(scanner, 0.5);
  EXPECT_EQ(result.model.scanner_origin, scanner);
  EXPECT_EQ(result.model.scanner_place, ScannerPlace::kGiven);
  EXPECT_EQ(result.model.points + result.out_of_range, result.tally.points);
  for (const Eigen::Vector3d& mean : result.model.leaves.means()) {
    const Eigen::Array3d outside = mean.array().abs() - Eigen::Array3d(6.0, 4.0, 1.5);
    EXPECT_LT(outside.maxCoeff(), 1e-6);
    EXPECT_LT(result.model.range_image.Around(mean).gap_m, 0.5);
  }
}

TEST(Ingest, RefusesAScanWithNothingUsable) {
  BoxScan scan(Eigen::Vector3d::Zero(), 0.5);
  IngestOptions options;
  options.min_range_m = 50.0;
  EXPECT_THROW(IngestScan("S1", scan, Eigen::Vector3d::Zero(), options, ExecutionContext{}),
               InputError);
}

TEST(Ingest, SaysWhereThePointsOfARefusedScanLie) {
  const auto error = [](const Eigen::Vector3d& center, const IngestOptions& options) {
    BoxScan scan(center, 0.5);
    try {
      IngestScan("S1", scan, std::nullopt, options, ExecutionContext{});
    } catch (const InputError& refused) {
      return std::string(refused.what());
    }
    return std::string();
  };
  const std::string map = error({690000.0, 5336000.0, 500.0}, {});
  EXPECT_THAT(map, HasSubstr("are farther than max_range_m, 1000 m, at 53804"));
  EXPECT_THAT(map, HasSubstr("give scanner_origin_m"));
  IngestOptions blind;
  blind.min_range_m = 50.0;
  const std::string near = error(Eigen::Vector3d::Zero(), blind);
  EXPECT_THAT(near, HasSubstr("are nearer than min_range_m, 50 m"));
  EXPECT_THAT(near, Not(HasSubstr("scanner_origin_m")));
}

}  // namespace
}  // namespace backsight
