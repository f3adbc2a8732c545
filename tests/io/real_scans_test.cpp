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

/// What a scan must hold, found by other programs than Backsight's readers.
struct Expected {
  const char* file;
  int scan_index;
  int scan_count;
  std::uint64_t records;
  std::uint64_t points;
  int columns;
  int rows;
  Eigen::Vector3d min;
  Eigen::Vector3d max;
};

WholeScan ExpectScan(const std::string& path, const Expected& expected) {
  WholeScan scan = ReadWhole(path, expected.scan_index);
  EXPECT_EQ(scan.info.scan_count, expected.scan_count) << path;
  EXPECT_EQ(scan.info.point_count, expected.records) << path;
  EXPECT_EQ(scan.tally.records, expected.records) << path;
  EXPECT_EQ(scan.points.size(), expected.points) << path;
  EXPECT_EQ(scan.tally.not_finite, 0U) << path;
  EXPECT_EQ(scan.info.columns, expected.columns) << path;
  EXPECT_EQ(scan.info.rows, expected.rows) << path;
  int axis = 0;
  for (const auto* values : {&scan.points.x, &scan.points.y, &scan.points.z}) {
    const auto [min, max] = std::minmax_element(values->begin(), values->end());
    EXPECT_DOUBLE_EQ(*min, expected.min[axis]) << path;
    EXPECT_DOUBLE_EQ(*max, expected.max[axis]) << path;
    ++axis;
  }
  return scan;
}

std::uint64_t Sum(const WholeScan& scan, std::size_t channel) {
  std::uint64_t sum = 0;
  for (const auto& rgb : scan.points.rgb) sum += rgb[channel];
  return sum;
}

TEST_F(RealScans, Ptx) {
  constexpr const char* kColor = "1.2-with-color.ptx";
  constexpr const char* kTurned = "complex-transform.ptx";
  constexpr const char* kTwo = "multiple-and-transform.ptx";
  constexpr const char* kPlain = "no-color.ptx";
  const std::vector<Expected> all{
      {kColor,
       0,
       1,
       1065,
       1065,
       15,
       71,
       {635619.85, 848899.7, 406.59},
       {638982.55, 853535.43, 586.38}},
      {kTurned, 0, 1, 12, 4, 2, 6, {-0.00563, 0.645218, -0.441879}, {-0.0056, 0.650467, -0.438828}},
      {kTwo, 0, 2, 4, 4, 2, 2, {36699.38, 48991.01, 12.695}, {37012.24, 49106.66, 23.195}},
      {kTwo, 1, 2, 4, 4, 4, 1, {636699.38, 848991.01, 425.39}, {637012.24, 849106.66, 446.39}},
      {kPlain, 0, 1, 15, 15, 15, 1, {635795.24, 848991.01, 408.6}, {637012.24, 849390.78, 446.39}}};
  std::vector<WholeScan> scans;
  for (const Expected& expected : all) {
    scans.push_back(ExpectScan(Path(std::string("formats/") + expected.file), expected));
    EXPECT_TRUE(scans.back().info.has_intensity);
    EXPECT_EQ(scans.back().info.has_rgb, scans.size() <= 2);
  }
  EXPECT_EQ(Sum(scans[0], 0), 129567U * 257);
  EXPECT_EQ(Sum(scans[0], 2), 134764U * 257);
  EXPECT_EQ(Sum(scans[1], 1), 149U * 257);
  EXPECT_EQ(scans[1].tally.no_return, 8U);
  ASSERT_TRUE(scans[1].info.world_from_scan);
  EXPECT_NEAR(scans[1].info.world_from_scan->translation.y(), -3.819741, 1e-12);
  EXPECT_FALSE(scans[2].info.world_from_scan);  // z is scaled by 2: no rigid motion
  EXPECT_THAT(scans[2].info.notes, ::testing::Contains(::testing::HasSubstr("no rigid motion")));
  EXPECT_TRUE(scans[3].info.world_from_scan);
  EXPECT_FLOAT_EQ(scans[4].points.intensity[0], 0.034912F);
}

TEST_F(RealScans, Pts) {
  const auto scan = ExpectScan(Path("formats/test.pts"), {"",
                                                          0,
                                                          1,
                                                          19,
                                                          19,
                                                          0,
                                                          0,
                                                          {-25.050461, -24.533554, -2.000961},
                                                          {3.980972, -2.006119, -0.010086}});
  EXPECT_EQ(scan.info.format, "PTS");
  EXPECT_NEAR(scan.points.intensity[0], (2048.0 - 1035.0) / 4095.0, 1e-6);
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{97 * 257, 59 * 257, 38 * 257}));
}

TEST_F(RealScans, LasWithExtraBytesAndEightBitColours) {
  const auto scan = ExpectScan(
      Path("formats/extrabytes.las"),
      {"", 0, 1, 1065, 1065, 0, 0, {635619.85, 848899.7, 406.59}, {638982.55, 853535.43, 586.38}});
  EXPECT_EQ(scan.info.format, "LAS 1.4");
  EXPECT_EQ(Sum(scan, 0), 129567U * 257);
  EXPECT_EQ(Sum(scan, 1), 118582U * 257);
  EXPECT_FLOAT_EQ(scan.points.intensity[0], 143.0F / 255.0F);
  const auto& classes = scan.points.classification;
  EXPECT_EQ(std::count(classes.begin(), classes.end(), 2), 276);
  // The note on week times; intensity and colours of 8 bits.
  EXPECT_EQ(scan.info.notes.size(), 3U);
  EXPECT_TRUE(scan.tally.notes.empty());
}

TEST_F(RealScans, LasWithGeoTiffAndExtendedRecords) {
  const auto scan =
      ExpectScan(Path("formats/simple1_4.las"),
                 {"", 0, 1, 22600, 22600, 0, 0, {1.0, 1.0, 44.0}, {226.0, 100.0, 254.0}});
  EXPECT_EQ(Sum(scan, 0), 961731840U);
  EXPECT_EQ(Sum(scan, 2), 827690240U);
  EXPECT_FALSE(scan.info.has_intensity);  // all 0
  EXPECT_EQ(scan.info.crs, "GeoTIFF: geographic, geodetic EPSG:4326");
  EXPECT_THAT(scan.info.notes, ::testing::Contains(::testing::HasSubstr("degrees")));
}

TEST_F(RealScans, LasOfVersion13) {
  const auto scan =
      ExpectScan(Path("formats/vegetation_1_3.las"), {"",
                                                      0,
                                                      1,
                                                      10683,
                                                      10683,
                                                      0,
                                                      0,
                                                      {-98451.205, -55975.417, -81460.091},
                                                      {-98447.447, -55969.405, -81455.203}});
  EXPECT_EQ(scan.info.format, "LAS 1.3");
  EXPECT_FALSE(scan.info.has_rgb);
  EXPECT_FLOAT_EQ(scan.points.intensity.front(), 3341.0F / 65535.0F);
  EXPECT_FLOAT_EQ(scan.points.intensity.back(), 8738.0F / 65535.0F);
  EXPECT_EQ(scan.points.classification[0], 11);
  EXPECT_TRUE(scan.tally.notes.empty());
}

/// A damaged copy of a real file ends in a scan or in an InputError.
TEST_F(RealScans, DamagedCopies) {
  for (const char* name : {"extrabytes.las", "vegetation_1_3.las", "test.pts"}) {
    ExpectSafeWhenDamaged(ReadBytes(Path(std::string("formats/") + name)), name, 20);
  }
}

TEST_F(RealScans, FormatsThatCannotBeRead) {
  const auto error = [&](const std::string& name) { return ReadError(Path("formats/" + name)); };
  for (const char* laz : {"plane.laz", "simple.laz", "1.2-with-color.copc.laz"}) {
    EXPECT_THAT(error(laz), ::testing::HasSubstr("laszip -i"));
  }
  EXPECT_THAT(error("plane.laz"), ::testing::HasSubstr("LAZ file"));
  EXPECT_THAT(error("1.2-with-color.copc.laz"), ::testing::HasSubstr("COPC file"));
}

}  // namespace
}  // namespace backsight
