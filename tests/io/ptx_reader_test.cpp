#include <gmock/gmock.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPose = "1 2 3\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n1 2 3 1\n";

std::string Header(int columns, int rows) {
  return std::to_string(columns) + "\n" + std::to_string(rows) + "\n" + kPose;
}

std::string WithWindowsLineEnds(const std::string& text) {
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return windows;
}

TEST(PtxReader, ReadsHeaderAndRecords) {
  const TempDir dir;
  const std::string text = Header(2, 2) + "1 2 3 0.5\n0 0 0 0.5\n-1.5 0 2e-3 1\nnan nan nan 0\n";
  for (const std::string& bytes : {text, WithWindowsLineEnds(text)}) {
    const auto scan = ReadWhole(dir.File("a.ptx", bytes));
    EXPECT_EQ(scan.info.format, "PTX");
    EXPECT_EQ(scan.info.columns, 2);
    EXPECT_EQ(scan.info.rows, 2);
    EXPECT_EQ(scan.info.scan_count, 1);
    EXPECT_EQ(scan.info.point_count, 4U);
    EXPECT_FALSE(scan.info.has_rgb);
    EXPECT_EQ(scan.tally.no_return, 1U);
    EXPECT_EQ(scan.tally.not_finite, 1U);
    EXPECT_EQ(scan.points.x, (std::vector<double>{1.0, -1.5}));
    EXPECT_EQ(scan.points.z, (std::vector<double>{3.0, 0.002}));
    EXPECT_EQ(scan.points.intensity, (std::vector<float>{0.5F, 1.0F}));
    EXPECT_EQ(scan.points.row, (std::vector<std::int32_t>{0, 0}));
    EXPECT_EQ(scan.points.column, (std::vector<std::int32_t>{0, 1}));
    ASSERT_TRUE(scan.info.world_from_scan);
    // The scanner's x axis is the first row of the header's matrix, its position the last.
    const Eigen::Vector3d x = *scan.info.world_from_scan * Eigen::Vector3d::UnitX();
    EXPECT_NEAR((x - Eigen::Vector3d(1, 3, 3)).norm(), 0.0, 1e-12);
  }
}

TEST(PtxReader, ReadsSeveralScans) {
  const TempDir dir;
  const std::string path = dir.File("a.ptx", Header(1, 2) + "1 1 1 0.1\n2 2 2 0.2\n" +
                                                 Header(1, 1) + "3 3 3 0.3 255 0 1\n" + "\n" +
                                                 Header(3, 1) + "4 4 4 2\n5 5 5 0\n0 0 0 0\n");
  const auto first = ReadWhole(path, 0);
  EXPECT_EQ(first.info.scan_count, 3);
  EXPECT_EQ(first.points.x, (std::vector<double>{1, 2}));
  const auto second = ReadWhole(path, 1);
  EXPECT_EQ(second.info.scan_index, 1);
  EXPECT_EQ(second.points.x, std::vector<double>{3});
  EXPECT_EQ(second.points.rgb[0], (std::array<std::uint16_t, 3>{65535, 0, 257}));
  const auto third = ReadWhole(path, 2);
  EXPECT_EQ(third.points.x, (std::vector<double>{4, 5}));
  EXPECT_THAT(third.tally.notes.at(0), HasSubstr("clamped in 1"));
  EXPECT_THAT(ReadError(path, 3), HasSubstr("scan_index from 0 to 2"));
  EXPECT_THAT(ReadError(path, -1), HasSubstr("scan_index from 0 to 2"));
}

TEST(PtxReader, ReadsAcrossChunks) {
  const TempDir dir;
  constexpr int kColumns = 300;
  constexpr int kRows = 450;
  std::string text = Header(kColumns, kRows);
  for (int i = 0; i < kColumns * kRows; ++i) {
    text += i % 5 == 0 ? "0 0 0 0.5\n" : std::to_string(i) + " 1 2 0.25\n";
  }
  const auto scan = ReadWhole(dir.File("a.ptx", text));
  EXPECT_EQ(scan.chunks, 9U);
  EXPECT_EQ(scan.tally.records, 135000U);
  EXPECT_EQ(scan.tally.no_return, 27000U);
  EXPECT_EQ(scan.points.x.front(), 1.0);
  EXPECT_EQ(scan.points.x.back(), 134999.0);
}

TEST(PtxReader, LeavesOutAMatrixThatIsNoPose) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File(
      "a.ptx",
      "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 2\n1 0 0 0\n0 1 0 0\n0 0 2 0\n0 0 0 1\n1 2 3 0.5\n"));
  EXPECT_FALSE(scan.info.world_from_scan);
  EXPECT_THAT(scan.info.notes.at(0), HasSubstr("no rigid motion"));
  EXPECT_EQ(scan.points.z, std::vector<double>{3});
}

TEST(PtxReader, NamesWhatIsWrong) {
  const TempDir dir;
  const auto error = [&](const std::string& bytes) { return ReadError(dir.File("a.ptx", bytes)); };
  const std::string good = "1 2 3 0.5\n";
  EXPECT_THAT(error(Header(1, 3) + good + "1 2 garbage 0.5\n" + good),
              HasSubstr("a.ptx:12: '1 2 garbage 0.5'; expected 4 numbers"));
  EXPECT_THAT(error(Header(1, 3) + good + "1 2 3 0.5 1 2 3\n" + good), HasSubstr("a.ptx:12"));
  EXPECT_THAT(error(Header(1, 3) + good + "\n" + good), HasSubstr("a.ptx:12: ''"));
  EXPECT_THAT(error(Header(1, 3) + "1 2 3\n" + good + good), HasSubstr("a.ptx:11: 3 values"));
  EXPECT_THAT(error(Header(1, 3) + good),
              HasSubstr("after 1 records; expected 3 records (1 columns * 3 rows, declared in "
                        "line 1)"));
  EXPECT_THAT(error(Header(9'999'999, 9'999'999) + good), HasSubstr("after 1 records"));
  EXPECT_THAT(error("5\n1000000000000000000\n" + std::string(kPose)), HasSubstr("a.ptx:2"));
  EXPECT_THAT(error("0\n5\n" + std::string(kPose)), HasSubstr("a.ptx:1: '0'"));
  EXPECT_THAT(error("-5\n5\n" + std::string(kPose)), HasSubstr("a.ptx:1: '-5'"));
  EXPECT_THAT(error("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0\n"),
              HasSubstr("a.ptx:8: '0 1 0'; expected row 2 of the matrix"));
  EXPECT_THAT(error("1\n1\n0 0 0\n1 0 0\n"), HasSubstr("a.ptx:5: the file ends here"));
  EXPECT_THAT(error("\n\n"), HasSubstr("no PTX header"));
}

TEST(PtxReader, DamageBehindCostsOnlyTheScansBehind) {
  const TempDir dir;
  const std::string path =
      dir.File("a.ptx", Header(1, 1) + "1 2 3 0.5\n" + Header(2, 2) + "1 2 3 0.5\n");
  const auto scan = ReadWhole(path, 0);
  EXPECT_EQ(scan.points.size(), 1U);
  EXPECT_THAT(scan.info.notes.at(0), HasSubstr("damaged behind this scan"));
  EXPECT_THAT(ReadError(path, 1), HasSubstr("declared in line 12"));
}

TEST(PtxReader, GivesUpWhileLookingForScans) {
  const TempDir dir;
  const std::string path = dir.File("a.ptx", Header(1, 2) + "1 1 1 0.1\n2 2 2 0.2\n");
  EXPECT_THROW(OpenScan(path, 0, {}, [] { throw Interrupted(); }), Interrupted);
}

TEST(PtxReader, SurvivesDamage) {
  std::string text = Header(2, 5);
  for (int i = 0; i < 10; ++i) text += "1.5 2.5 -3.5 0.25 1 2 3\n";
  ExpectSafeWhenDamaged(text + Header(1, 1) + "1 2 3 0.5\n", "a.ptx");
}

}  // namespace
}  // namespace backsight
