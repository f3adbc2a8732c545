#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

struct Axis {
  double min, max, sum;
};

/// One scan of a real file, as an independent decoder of ours in another language found it; counts
/// and bounds also stand in the files' XML. Sums are those of all points.
struct Expected {
  std::string file;
  int scan_index = 0;
  int scan_count = 1;
  std::string guid;
  std::uint64_t records = 0;
  std::size_t points = 0;
  Axis x{}, y{}, z{};
};

const std::vector<Expected>& RealFiles() {
  static const std::vector<Expected> files = {
      {"A_B.e57",
       0,
       2,
       "{d3d0f9b8-6722-4ee4-9ee9-46a7a81f732c}",
       2,
       2,
       {-42.64229965209961, -42.63949966430664, -85.28179931640625},
       {1.8725999593734741, 2.057800054550171, 3.930400013923645},
       {0.5101000070571899, 0.666700005531311, 1.176800012588501}},
      {"A_B.e57",
       1,
       2,
       "{3e80c997-fbd5-4b07-ba33-9b79f63247fa}",
       4,
       4,
       {-44.95220184326172, -44.30009841918945, -178.20790100097656},
       {-1.3493000268936157, -0.8859999775886536, -4.253399968147278},
       {-0.607699990272522, 0.3693999946117401, 0.4260999858379364}},
      {"A_moved_B.e57",
       1,
       2,
       "{13288ae4-79e2-414f-ae0c-dfd05eabb5da}",
       4,
       4,
       {-44.11943817138672, -43.46733474731445, -174.87684631347656},
       {0.7053028345108032, 1.1686029434204102, 3.9650115966796875},
       {-0.607699990272522, 0.3693999946117401, 0.4260999858379364}},
      {"bunnyFloat.e57",
       0,
       1,
       "{9CA24C38-C93E-40E8-A366-F49977C7E3EB}",
       30571,
       30571,
       {-0.09468899667263031, 0.0610090009868145, -841.0932977735692},
       {0.040010999888181686, 0.1873210072517395, 3151.198741853237},
       {-0.061873000115156174, 0.05879899859428406, 264.2439720416619}},
      {"bunnyInt19.e57",
       0,
       1,
       "{9CA24C38-C93E-40E8-A366-F49977C7E3EB}",
       30571,
       30571,
       {-0.094689, 0.061008999999999994, -841.093298},
       {0.040011, 0.187321, 3151.198742},
       {-0.061873, 0.058799, 264.243972}},
      {"bunnyInt24.e57",
       0,
       1,
       "{9CA24C38-C93E-40E8-A366-F49977C7E3EB}",
       30571,
       30571,
       {-0.094689, 0.061008999999999994, -841.093298},
       {0.040011, 0.187321, 3151.198742},
       {-0.061873, 0.058799, 264.243972}},
      {"cartesian_invalid_state_single.e57",
       0,
       1,
       "pc_guid",
       3,
       1,
       {-1, -1, -1},
       {-2, -2, -2},
       {-3, -3, -3}},
      {"las2e57_no_images_tag.e57",
       0,
       1,
       "98d85152-82b3-4120-b06e-0c1bb10b6dec",
       153,
       153,
       {-0.5, 0.5, -0.898},
       {-0.5, 0.5, -0.129},
       {-0.5, 0.5, -0.035}},
      {"pipeSpherical.e57",
       0,
       1,
       "{f9a9c7ec-1a86-4874-8f29-2c105f70b969}",
       1220,
       1220,
       {-1.237929344177246, -0.31987011432647705, -832.9608074426651},
       {-5.127488136291504, -4.570023536682129, -5936.491968154907},
       {1.437207579612732, 1.8430029153823853, 1928.2271935939789}},
      {"tinyCartesianFloatRgb.e57",
       0,
       1,
       "{49aa8f8b-618f-423e-a632-f9a58ad79e40}",
       2090,
       2090,
       {-9.779529571533203, -6.774238109588623, -16812.262330532074},
       {4.513879299163818, 7.51546049118042, 12566.194438457489},
       {295.5246887207031, 298.53216552734375, 620734.6056213379}},
      {"tiny_spherical.e57",
       0,
       1,
       "{46F13A20-67A0-4335-AA42-069000640085}",
       360,
       180,
       {6.341362302269048e-07, 1.0, 89.95435666933113},
       {-0.499998573193859, 0.49999984146591736, 0.0008690215441082027},
       {0.0, 0.9999996829318346, 114.6459050783777}},
      {"translationWithoutRotation.e57",
       0,
       1,
       "{20c83b5e-8c64-4cd4-81ab-933ceebede9c}",
       4,
       4,
       {0, 1, 2},
       {0, 1, 2},
       {0, 0, 0}},
  };
  return files;
}

class E57RealFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* root = std::getenv("BACKSIGHT_DATA");
    root_ = std::filesystem::path(root != nullptr ? root : "../shared/data") / "formats";
    if (!std::filesystem::is_directory(root_)) GTEST_SKIP() << "skipped: no data";
  }

  std::string Path(const std::string& name) const { return (root_ / name).string(); }

  std::filesystem::path root_;
};

void ExpectAxis(const std::vector<double>& values, const Axis& expected) {
  EXPECT_EQ(*std::min_element(values.begin(), values.end()), expected.min);
  EXPECT_EQ(*std::max_element(values.begin(), values.end()), expected.max);
  // The order of summation differs: 30571 sums of at most 6e5, each rounded by 1e-16 of that.
  EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0), expected.sum, 1e-6);
}

TEST_F(E57RealFiles, AreReadWithTheirCountsAndBounds) {
  for (const Expected& expected : RealFiles()) {
    SCOPED_TRACE(expected.file + " " + std::to_string(expected.scan_index));
    const auto scan = ReadWhole(Path(expected.file), expected.scan_index);
    EXPECT_EQ(scan.info.scan_count, expected.scan_count);
    EXPECT_EQ(scan.info.guid, expected.guid);
    EXPECT_EQ(scan.info.point_count, expected.records);
    EXPECT_EQ(scan.tally.records, expected.records);
    EXPECT_EQ(scan.tally.no_return, expected.records - expected.points);
    ASSERT_EQ(scan.points.size(), expected.points);
    ExpectAxis(scan.points.x, expected.x);
    ExpectAxis(scan.points.y, expected.y);
    ExpectAxis(scan.points.z, expected.z);
  }
}

TEST_F(E57RealFiles, EveryFileIsCoveredByATest) {
  for (const auto& entry : std::filesystem::directory_iterator(root_)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".e57" || name == "corrupt_crc.e57" || name == "empty_pc.e57") {
      continue;
    }
    EXPECT_TRUE(std::any_of(RealFiles().begin(), RealFiles().end(), [&name](const Expected& e) {
      return e.file == name;
    })) << name;
  }
}

TEST_F(E57RealFiles, IntensityAndColourAreScaledByTheirLimits) {
  const auto clouds = ReadWhole(Path("A_B.e57"), 1);
  EXPECT_THAT(clouds.points.intensity, ::testing::Contains(1.0F));
  EXPECT_EQ(clouds.points.rgb[0], (std::array<std::uint16_t, 3>{0, 65535, 0}));
  const auto pipe = ReadWhole(Path("pipeSpherical.e57"));
  constexpr double kLow = 0.393505662679672241;
  constexpr double kHigh = 0.555497884750366211;
  EXPECT_NEAR(pipe.points.intensity[0], (0.4514297842979431 - kLow) / (kHigh - kLow), 1e-7);
  EXPECT_EQ(pipe.points.rgb[0], (std::array<std::uint16_t, 3>{70 * 257, 79 * 257, 50 * 257}));
  EXPECT_TRUE(pipe.tally.notes.empty());
  const auto las = ReadWhole(Path("las2e57_no_images_tag.e57"));
  EXPECT_EQ(las.points.rgb[0], (std::array<std::uint16_t, 3>{0, 0, 65280}));
}

TEST_F(E57RealFiles, PosesAreRecordedNotApplied) {
  const auto moved = ReadWhole(Path("translationWithoutRotation.e57")).info;
  EXPECT_EQ(moved.world_from_scan->translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(moved.world_from_scan->rotation.isIdentity());
  EXPECT_EQ(moved.name, "Scan 0");
  EXPECT_TRUE(ReadWhole(Path("bunnyFloat.e57")).info.world_from_scan->Matrix().isIdentity());
}

TEST_F(E57RealFiles, AnEmptyCloudIsAnEmptyScan) {
  const auto scan = ReadWhole(Path("empty_pc.e57"));
  EXPECT_EQ(scan.info.point_count, 0U);
  EXPECT_EQ(scan.chunks, 0U);
  EXPECT_TRUE(scan.points.empty());
}

TEST_F(E57RealFiles, ADamagedPageIsNamed) {
  EXPECT_THAT(ReadError(Path("corrupt_crc.e57")),
              HasSubstr("corrupt_crc.e57: byte 33792: page 33 with checksum fe42c534; expected "
                        "checksum 1252607a"));
}

}  // namespace
}  // namespace backsight
