#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

/// Files written by other software; not part of the project.
class RealScans : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* root = std::getenv("BACKSIGHT_DATA");
    root_ = root != nullptr ? root : "../shared/data";
    if (!fs::is_directory(root_)) GTEST_SKIP() << "skipped: no data";
  }

  std::string Path(const std::string& name) const { return (root_ / name).string(); }

  std::vector<std::string> Files(const std::string& folder, const std::string& extension) const {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(root_ / folder)) {
      if (entry.path().extension() == extension) files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    return files;
  }

  fs::path root_;
};

double Extent(const std::vector<double>& values) {
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  return *max - *min;
}

void ExpectExtents(const WholeScan& scan, double low_m, double high_m) {
  for (const auto* axis : {&scan.points.x, &scan.points.y, &scan.points.z}) {
    EXPECT_GT(Extent(*axis), low_m) << scan.info.path;
    EXPECT_LT(Extent(*axis), high_m) << scan.info.path;
  }
}

TEST_F(RealScans, Pcd) {
  const auto files = Files("eth_facade", ".pcd");
  EXPECT_EQ(files.size(), 7U);
  for (const std::string& file : files) {
    const auto scan = ReadWhole(file);
    EXPECT_EQ(scan.tally.records, scan.info.point_count);
    EXPECT_EQ(scan.tally.points, scan.tally.records);
    EXPECT_TRUE(scan.info.has_rgb);
    ExpectExtents(scan, 2.0, 200.0);
  }
}

TEST_F(RealScans, Ply) {
  for (const std::string folder : {"3dmatch_kitchen", "corr/turboreg_kitti"}) {
    const auto files = Files(folder, ".ply");
    EXPECT_EQ(files.size(), 6U);
    for (const std::string& file : files) {
      const auto scan = ReadWhole(file);
      EXPECT_EQ(scan.tally.records, scan.info.point_count);
      EXPECT_EQ(scan.tally.points, scan.tally.records);
      ExpectExtents(scan, 0.5, folder == "3dmatch_kitchen" ? 20.0 : 300.0);
    }
  }
}

TEST_F(RealScans, Ptx) {
  for (const std::string& file : Files("formats", ".ptx")) {
    const int scans = OpenScan(file)->info().scan_count;
    for (int i = 0; i < scans; ++i) {
      const auto scan = ReadWhole(file, i);
      EXPECT_EQ(scan.tally.records, scan.info.point_count);
      EXPECT_EQ(scan.tally.not_finite, 0U);
    }
  }
  EXPECT_EQ(OpenScan(Path("formats/multiple-and-transform.ptx"))->info().scan_count, 2);
  const auto posed = ReadWhole(Path("formats/complex-transform.ptx"));
  EXPECT_EQ(posed.tally.no_return, 8U);
  EXPECT_EQ(posed.points.size(), 4U);
  ASSERT_TRUE(posed.info.world_from_scan);
  EXPECT_NEAR(posed.info.world_from_scan->translation.y(), -3.819741, 1e-12);
}

TEST_F(RealScans, Pts) {
  const auto scan = ReadWhole(Path("formats/test.pts"));
  EXPECT_EQ(scan.tally.points, 19U);
  EXPECT_EQ(scan.info.point_count, 19U);
  EXPECT_NEAR(scan.points.intensity[0], (2048.0 - 1035.0) / 4095.0, 1e-6);
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{97 * 257, 59 * 257, 38 * 257}));
}

TEST_F(RealScans, FormatsThatCannotBeRead) {
  const auto error = [&](const std::string& name) { return ReadError(Path("formats/" + name)); };
  EXPECT_THAT(error("simple1_4.las"), ::testing::HasSubstr("LAS file"));
  EXPECT_THAT(error("plane.laz"), ::testing::HasSubstr("LAZ file"));
  EXPECT_THAT(error("1.2-with-color.copc.laz"), ::testing::HasSubstr("COPC file"));
}

}  // namespace
}  // namespace backsight
