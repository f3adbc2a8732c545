#include <gmock/gmock.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

std::string XyzHeader(const std::string& format, std::size_t points) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " +
         std::to_string(points) +
         "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
}

TEST(PlyReader, ReadsAscii) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File(
      "a.ply",
      "ply\r\nformat ascii 1.0\r\nobj_info any\r\nelement vertex 2\r\nproperty double x\r\n"
      "property double y\r\nproperty double z\r\nproperty uchar red\r\nproperty uchar green\r\n"
      "property uchar blue\r\nproperty float scalar_Intensity\r\nelement face 1\r\n"
      "property list uchar int vertex_indices\r\nend_header\r\n"
      "0.1 0.2 0.3 255 0 1 0.5\r\n1 2 nan 1 2 3 0.5\r\n3 0 1 1\r\n"));
  EXPECT_EQ(scan.info.format, "PLY");
  EXPECT_EQ(scan.info.point_count, 2U);
  EXPECT_EQ(scan.tally.not_finite, 1U);
  EXPECT_EQ(scan.points.x, std::vector<double>{0.1});
  EXPECT_EQ(scan.points.z, std::vector<double>{0.3});
  EXPECT_EQ(scan.points.intensity, std::vector<float>{0.5F});
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{65535, 0, 257}));
}

class PlyBinary : public ::testing::TestWithParam<std::endian> {
 protected:
  static std::string Format() {
    return GetParam() == std::endian::big ? "binary_big_endian" : "binary_little_endian";
  }
};

TEST_P(PlyBinary, ReadsAcrossChunks) {
  const TempDir dir;
  constexpr std::size_t kPoints = 65536 + 7;
  std::string bytes = "ply\nformat " + Format() + " 1.0\nelement vertex " +
                      std::to_string(kPoints) +
                      "\nproperty short skipped\nproperty double x\nproperty double y\n"
                      "property int z\nproperty ushort red\nproperty ushort green\n"
                      "property ushort blue\nproperty ushort intensity\nend_header\n";
  for (std::size_t i = 0; i < kPoints; ++i) {
    Append(bytes, std::int16_t{-1}, GetParam());
    Append(bytes, static_cast<double>(i) / 3.0, GetParam());
    Append(bytes, 2.5, GetParam());
    Append(bytes, -static_cast<std::int32_t>(i), GetParam());
    for (std::uint16_t c = 0; c < 3; ++c) {
      Append(bytes, static_cast<std::uint16_t>(1000 + c), GetParam());
    }
    Append(bytes, std::uint16_t{13107}, GetParam());
  }
  const auto scan = ReadWhole(dir.File("a.ply", bytes));
  EXPECT_EQ(scan.chunks, 5U);
  ASSERT_EQ(scan.points.size(), kPoints);
  for (std::size_t i = 0; i < kPoints; i += 511) {
    EXPECT_EQ(scan.points.x[i], static_cast<double>(i) / 3.0);
    EXPECT_EQ(scan.points.y[i], 2.5);
    EXPECT_EQ(scan.points.z[i], -static_cast<double>(i));
  }
  EXPECT_EQ(scan.points.rgb.back(), (std::array<std::uint16_t, 3>{1000, 1001, 1002}));
  EXPECT_FLOAT_EQ(scan.points.intensity.back(), 0.2F);
}

TEST_P(PlyBinary, StepsOverListsInAndBeforeVertices) {
  const TempDir dir;
  std::string bytes = "ply\nformat " + Format() +
                      " 1.0\nelement strip 2\nproperty list uchar double v\nproperty char end\n"
                      "element fixed 3\nproperty int a\nelement empty 4\nelement vertex 2\n"
                      "property float x\nproperty list ushort float echoes\nproperty float y\n"
                      "property float z\nelement face 0\nend_header\n";
  for (const std::uint8_t n : {std::uint8_t{3}, std::uint8_t{0}}) {
    Append(bytes, n);
    for (int i = 0; i < n; ++i) Append(bytes, 9.0, GetParam());
    Append(bytes, std::int8_t{1});
  }
  for (int i = 0; i < 3; ++i) Append(bytes, i, GetParam());
  for (const std::uint16_t n : {std::uint16_t{0}, std::uint16_t{2}}) {
    Append(bytes, 1.5F, GetParam());
    Append(bytes, n, GetParam());
    for (int i = 0; i < n; ++i) Append(bytes, 8.0F, GetParam());
    Append(bytes, 2.5F, GetParam());
    Append(bytes, 3.5F, GetParam());
  }
  const auto scan = ReadWhole(dir.File("a.ply", bytes));
  EXPECT_EQ(scan.points.x, (std::vector<double>{1.5, 1.5}));
  EXPECT_EQ(scan.points.y, (std::vector<double>{2.5, 2.5}));
  EXPECT_EQ(scan.points.z, (std::vector<double>{3.5, 3.5}));
}

INSTANTIATE_TEST_SUITE_P(Orders, PlyBinary,
                         ::testing::Values(std::endian::little, std::endian::big));

TEST(PlyReader, StepsOverAsciiElementsBefore) {
  const TempDir dir;
  const auto scan = ReadWhole(
      dir.File("a.ply",
               "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int v\n"
               "element vertex 1\nproperty float x\nproperty list int int more\nproperty float y\n"
               "property float z\nend_header\n3 1 2 3\n1 4\n7 2 100 200 8 9\n"));
  EXPECT_EQ(scan.points.x, std::vector<double>{7});
  EXPECT_EQ(scan.points.y, std::vector<double>{8});
  EXPECT_EQ(scan.points.z, std::vector<double>{9});
}

TEST(PlyReader, ReadsEmptyCloud) {
  const TempDir dir;
  EXPECT_EQ(ReadWhole(dir.File("a.ply", XyzHeader("binary_little_endian", 0))).tally.records, 0U);
}

TEST(PlyReader, NamesWhatIsWrong) {
  const TempDir dir;
  const auto error = [&](const std::string& bytes) { return ReadError(dir.File("a.ply", bytes)); };
  EXPECT_THAT(
      error(XyzHeader("binary_little_endian", 3) + std::string(25, 'a')),
      HasSubstr("only 2 records of element 'vertex' are available; expected the declared 3"));
  EXPECT_THAT(error(XyzHeader("binary_big_endian", 1'000'000'000'000'000'000)),
              HasSubstr("the declared 1000000000000000000"));
  EXPECT_THAT(error(XyzHeader("ascii", 2) + "1 2 3\n4 5\n"), HasSubstr("a.ply:10: 2 values"));
  EXPECT_THAT(error(XyzHeader("ascii", 2) + "1 2 3\n4 5 6 7\n"), HasSubstr("a.ply:10: 4 values"));
  EXPECT_THAT(error(XyzHeader("ascii", 1) + "1 2 x?\n"), HasSubstr("a.ply:9: 'x?'"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex -4\n"), HasSubstr("a.ply:3"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement face 4\nend_header\n"),
              HasSubstr("no element 'vertex'"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("lacks a coordinate"));
  EXPECT_THAT(error("ply\nformat ascii 2.0\n"), HasSubstr("a.ply:2"));
  EXPECT_THAT(error("ply\nelement vertex 1\nend_header\n"), HasSubstr("no format line"));
  std::string list =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int int v\n"
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  Append(list, std::int32_t{-5});
  EXPECT_THAT(error(list + std::string(40, 'a')), HasSubstr("a list 'v' of -5 entries"));
  list.replace(list.find(" v\n") + 1, 1, "\xD1\x1B[");  // messages stay clean text
  EXPECT_THAT(error(list + std::string(40, 'a')), HasSubstr("a list '\\xd1\\x1b[' of -5 entries"));
}

TEST(PlyReader, SurvivesDamage) {
  std::string bytes = XyzHeader("binary_little_endian", 20);
  for (int i = 0; i < 60; ++i) Append(bytes, static_cast<float>(i));
  ExpectSafeWhenDamaged(bytes, "b.ply");
  ExpectSafeWhenDamaged(XyzHeader("ascii", 3) + "1 2 3\n4 5 6\n7.5 8.5 9.5\n", "a.ply");
  std::string lists =
      "ply\nformat binary_big_endian 1.0\nelement face 3\nproperty list uint uchar v\n"
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (int i = 0; i < 3; ++i) {
    Append(lists, std::uint32_t{2}, std::endian::big);
    lists += "ab";
  }
  for (int i = 0; i < 6; ++i) Append(lists, static_cast<float>(i), std::endian::big);
  ExpectSafeWhenDamaged(lists, "c.ply");
}

}  // namespace
}  // namespace backsight
