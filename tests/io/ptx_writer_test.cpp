#include "io/ptx_writer.h"

#include <gtest/gtest.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

TEST(PtxWriter, IsReadBack) {
  const TempDir dir;
  const std::string path = dir / "a.ptx";
  Random random(1);
  const RigidTransform pose{random.Rotation(), {691000.123456789, -2.5, 1e-3}};
  PtxWriter writer(path);
  writer.BeginScan({.columns = 2, .rows = 3, .has_rgb = true, .world_from_scan = pose});
  for (int i = 0; i < 5; ++i) {
    writer.AddPoint({1.25 + i, -0.000002, 3.0}, 0.1 * i, {255, 0, static_cast<std::uint8_t>(i)});
  }
  writer.AddNoReturn();
  writer.BeginScan({.columns = 1, .rows = 1, .has_rgb = false, .world_from_scan = {}});
  writer.AddPoint({1, 2, 3}, 1.0);
  writer.Finish();

  const auto first = ReadWhole(path, 0);
  EXPECT_EQ(first.info.scan_count, 2);
  EXPECT_EQ(first.info.columns, 2);
  EXPECT_EQ(first.info.rows, 3);
  EXPECT_EQ(first.tally.no_return, 1U);
  EXPECT_EQ(first.points.x, (std::vector<double>{1.25, 2.25, 3.25, 4.25, 5.25}));
  EXPECT_EQ(first.points.y, std::vector<double>(5, -0.000002));
  EXPECT_FLOAT_EQ(first.points.intensity[4], 0.4F);
  EXPECT_EQ(first.points.rgb[4], (std::array<std::uint16_t, 3>{65535, 0, 4 * 257}));
  ASSERT_TRUE(first.info.world_from_scan);
  EXPECT_EQ(first.info.world_from_scan->translation, pose.translation);
  EXPECT_LT((first.info.world_from_scan->rotation - pose.rotation).norm(), 1e-14);
  const auto second = ReadWhole(path, 1);
  EXPECT_FALSE(second.info.has_rgb);
  EXPECT_EQ(second.points.z, std::vector<double>{3});
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(PtxWriter, AnyScanIsReadBack) {
  const TempDir dir;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    PtxWriter::Scan scan;
    scan.columns = 1 + static_cast<int>(random.Index(20));
    scan.rows = 1 + static_cast<int>(random.Index(20));
    scan.has_rgb = random.Index(2) == 0;
    scan.world_from_scan = {random.Rotation(), {random.Uniform(-1e7, 1e7), 0.0, 1.0}};
    PtxWriter writer(dir / "a.ptx");
    writer.BeginScan(scan);
    PointChunk truth;
    for (int i = 0; i < scan.columns * scan.rows; ++i) {
      if (random.Index(4) == 0) {
        writer.AddNoReturn();
        continue;
      }
      const Eigen::Vector3d point(random.Uniform(-300, 300), random.Uniform(-300, 300), 1.0);
      const auto level = static_cast<std::uint8_t>(random.Index(256));
      truth.x.push_back(point.x());
      truth.y.push_back(point.y());
      truth.intensity.push_back(static_cast<float>(random.Uniform()));
      if (scan.has_rgb) truth.rgb.push_back({static_cast<std::uint16_t>(257 * level), 0, 0});
      writer.AddPoint(point, static_cast<double>(truth.intensity.back()), {level, 0, 0});
    }
    writer.Finish();
    const auto read = ReadWhole(dir / "a.ptx");
    EXPECT_EQ(read.info.columns, scan.columns);
    EXPECT_EQ(read.info.rows, scan.rows);
    ASSERT_EQ(read.points.size(), truth.size());
    EXPECT_EQ(read.tally.records, read.info.point_count);
    if (truth.empty()) continue;
    EXPECT_EQ(read.points.rgb, truth.rgb);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      ASSERT_NEAR(read.points.x[i], truth.x[i], 0.501e-6);  // written to the micrometre
      ASSERT_NEAR(read.points.y[i], truth.y[i], 0.501e-6);
      ASSERT_NEAR(read.points.intensity[i], truth.intensity[i], 1e-4);
    }
  }
}

TEST(PtxWriter, WantsExactlyOneRecordPerCell) {
  const TempDir dir;
  {
    PtxWriter writer(dir / "a.ptx");
    EXPECT_THROW(writer.AddNoReturn(), InternalError);
    writer.BeginScan({.columns = 1, .rows = 1, .has_rgb = false, .world_from_scan = {}});
    EXPECT_THROW(writer.Finish(), InternalError);
    writer.AddNoReturn();
    EXPECT_THROW(writer.AddNoReturn(), InternalError);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

}  // namespace
}  // namespace backsight
