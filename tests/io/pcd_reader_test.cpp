#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string Header(const std::string& data, std::size_t points, const std::string& fields,
                   const std::string& viewpoint = "0 0 0 1 0 0 0") {
  const std::string n = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + fields + "WIDTH " + n +
         "\nHEIGHT 1\nVIEWPOINT " + viewpoint + "\nPOINTS " + n + "\nDATA " + data + "\n";
}

constexpr const char* kXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
constexpr const char* kRich =
    "FIELDS normal x y z rgb intensity\nSIZE 4 8 8 8 4 1\nTYPE F F F F U U\nCOUNT 3 1 1 1 1 1\n";

/// One record of the kRich layout.
void AppendRich(std::string& bytes, double x, double y, double z, std::uint32_t rgb,
                std::uint8_t intensity) {
  for (int i = 0; i < 3; ++i) Append(bytes, 0.5F);
  Append(bytes, x), Append(bytes, y), Append(bytes, z);
  Append(bytes, rgb), Append(bytes, intensity);
}

/// LZF of literals only, but for runs of one byte, which become back references.
std::string PackLzf(const std::string& bytes) {
  std::string packed;
  for (std::size_t i = 0; i < bytes.size();) {
    std::size_t run = 1;
    while (i + run < bytes.size() && bytes[i + run] == bytes[i] && run < 264) ++run;
    if (run >= 12) {
      packed += '\0';
      packed += bytes[i];
      const std::size_t copy = run - 1;  // 11 to 263: always the long form
      packed += static_cast<char>(7U << 5U);
      packed += static_cast<char>(copy - 9);
      packed += '\0';
      i += run;
    } else {
      const std::size_t n = std::min<std::size_t>(bytes.size() - i, 7);
      packed += static_cast<char>(n - 1);
      packed += bytes.substr(i, n);
      i += n;
    }
  }
  return packed;
}

std::string Compressed(const std::string& columns) {
  const std::string packed = PackLzf(columns);
  std::string bytes;
  Append(bytes, static_cast<std::uint32_t>(packed.size()));
  Append(bytes, static_cast<std::uint32_t>(columns.size()));
  return bytes + packed;
}

TEST(PcdReader, ReadsAscii) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File(
      "a.pcd", Header("ascii", 3, "FIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F U F\n") +
                   "1 -2.5 3e1 16711935 0.25\r\nnan 0 0 0 0\n+0.5 0 0 255 7\n"));
  EXPECT_EQ(scan.info.format, "PCD");
  EXPECT_EQ(scan.info.point_count, 3U);
  EXPECT_EQ(scan.tally.not_finite, 1U);
  EXPECT_EQ(scan.points.x, (std::vector<double>{1.0, 0.5}));
  EXPECT_EQ(scan.points.y, (std::vector<double>{-2.5, 0.0}));
  EXPECT_EQ(scan.points.z, (std::vector<double>{30.0, 0.0}));
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{65535, 0, 65535}));
  EXPECT_EQ(scan.points.intensity, (std::vector<float>{0.25F, 1.0F}));
  ASSERT_EQ(scan.tally.notes.size(), 1U);
  EXPECT_THAT(scan.tally.notes[0], HasSubstr("clamped in 1 of 2"));
}

TEST(PcdReader, ReadsPackedFloatColor) {
  const TempDir dir;
  std::string bytes =
      Header("binary", 1, "FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n");
  Append(bytes, 1.0F), Append(bytes, 2.0F), Append(bytes, 3.0F);
  Append(bytes, std::bit_cast<float>(std::uint32_t{0x00010203}));
  const auto scan = ReadWhole(dir.File("a.pcd", bytes));
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{257, 514, 771}));
}

TEST(PcdReader, ReadsBinaryWithSkippedFieldsAcrossChunks) {
  const TempDir dir;
  constexpr std::size_t kPoints = 2 * 65536 + 3;
  std::string bytes = Header("binary", kPoints, kRich);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const auto v = static_cast<double>(i);
    AppendRich(bytes, i == 70000 ? kNaN : v + 0.125, -v, 5.0, static_cast<std::uint32_t>(i),
               static_cast<std::uint8_t>(i % 256));
  }
  const auto scan = ReadWhole(dir.File("a.pcd", bytes));
  EXPECT_EQ(scan.chunks, 9U);
  EXPECT_EQ(scan.tally.records, kPoints);
  EXPECT_EQ(scan.tally.not_finite, 1U);
  for (const std::size_t i : {std::size_t{0}, std::size_t{65535}, std::size_t{65536}}) {
    EXPECT_EQ(scan.points.x[i], static_cast<double>(i) + 0.125);
    EXPECT_EQ(scan.points.rgb[i][2], (i & 0xFFU) * 257);
    EXPECT_FLOAT_EQ(scan.points.intensity[i], static_cast<float>(i % 256) / 255.0F);
  }
  EXPECT_EQ(scan.points.x.back(), static_cast<double>(kPoints - 1) + 0.125);
}

TEST(PcdReader, ReadsBinaryCompressed) {
  const TempDir dir;
  constexpr std::size_t kPoints = 70000;
  std::string columns;
  for (std::size_t i = 0; i < 3 * kPoints; ++i) Append(columns, 0.0F);
  for (std::size_t i = 0; i < kPoints; ++i) Append(columns, static_cast<double>(i));
  for (std::size_t i = 0; i < kPoints; ++i) Append(columns, 7.0);
  for (std::size_t i = 0; i < kPoints; ++i) Append(columns, -static_cast<double>(i));
  for (std::size_t i = 0; i < kPoints; ++i) Append(columns, std::uint32_t{0x00FF0000});
  for (std::size_t i = 0; i < kPoints; ++i) Append(columns, std::uint8_t{51});
  const auto scan = ReadWhole(
      dir.File("a.pcd", Header("binary_compressed", kPoints, kRich) + Compressed(columns)));
  ASSERT_EQ(scan.points.size(), kPoints);
  for (std::size_t i = 0; i < kPoints; i += 997) {
    EXPECT_EQ(scan.points.x[i], static_cast<double>(i));
    EXPECT_EQ(scan.points.y[i], 7.0);
    EXPECT_EQ(scan.points.z[i], -static_cast<double>(i));
    EXPECT_EQ(scan.points.rgb[i], (std::array<std::uint16_t, 3>{65535, 0, 0}));
    EXPECT_FLOAT_EQ(scan.points.intensity[i], 0.2F);
  }
}

TEST(PcdReader, ReadsGridAndOldVersion) {
  const TempDir dir;
  const auto scan = ReadWhole(
      dir.File("a.pcd",
               "VERSION .5\nFIELDS x y z\nSIZE 4 2 1\nTYPE F I U\nWIDTH 2\nHEIGHT 2\nDATA ascii\n"
               "1 2 3\n0 0 0\n1 -2 3\nnan nan nan\n"));
  EXPECT_EQ(scan.info.rows, 2);
  EXPECT_EQ(scan.info.columns, 2);
  EXPECT_FALSE(scan.info.world_from_scan);
  EXPECT_EQ(scan.tally.no_return, 1U);
  EXPECT_EQ(scan.tally.not_finite, 1U);
  EXPECT_EQ(scan.points.y, (std::vector<double>{2, -2}));
}

TEST(PcdReader, RecordsViewpoint) {
  const TempDir dir;
  const double h = std::sqrt(0.5);
  const std::string point = "1 2 3\n";
  const auto turned = ReadWhole(dir.File(
      "a.pcd",
      Header("ascii", 1, kXyz, "1 2 3 " + std::to_string(h) + " 0 0 " + std::to_string(h)) +
          point));
  ASSERT_TRUE(turned.info.world_from_scan);
  EXPECT_TRUE(turned.info.world_from_scan->IsValid());
  const Eigen::Vector3d x = *turned.info.world_from_scan * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((x - Eigen::Vector3d(1, 3, 3)).norm(), 0.0, 1e-6);
  EXPECT_EQ(turned.points.x[0], 1.0);
  ASSERT_EQ(turned.info.notes.size(), 1U);
  EXPECT_THAT(turned.info.notes[0], HasSubstr("VIEWPOINT"));
  const auto plain = ReadWhole(dir.File("a.pcd", Header("ascii", 1, kXyz) + point));
  EXPECT_TRUE(plain.info.world_from_scan);
  EXPECT_TRUE(plain.info.notes.empty());
  const auto bad = ReadWhole(dir.File("a.pcd", Header("ascii", 1, kXyz, "0 0 0 0 0 0 0") + point));
  EXPECT_FALSE(bad.info.world_from_scan);
  EXPECT_EQ(bad.info.notes.size(), 1U);
}

TEST(PcdReader, NamesWhatIsWrong) {
  const TempDir dir;
  const auto error = [&](const std::string& bytes) { return ReadError(dir.File("a.pcd", bytes)); };
  EXPECT_THAT(error(Header("binary", 10, kXyz) + std::string(60, '\0')),
              HasSubstr("only 5 points are available; expected the declared 10 points"));
  EXPECT_THAT(error(Header("binary", 1'000'000'000'000'000'000, kXyz) + "12345"),
              HasSubstr("only 0 points"));
  EXPECT_THAT(error("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH -3\n"),
              HasSubstr("a.pcd:5: '-3'"));
  EXPECT_THAT(error("VERSION 0.7\n" + std::string(kXyz) +
                    "WIDTH 4294967296\nHEIGHT 4294967296\nPOINTS 0\nDATA binary\n"),
              HasSubstr("POINTS = WIDTH * HEIGHT"));
  EXPECT_THAT(error(Header("ascii", 2, kXyz) + "1 2 3\n1 2\n"), HasSubstr("a.pcd:13: 2 values"));
  EXPECT_THAT(error(Header("ascii", 2, kXyz) + "1 2 3\n1 2 abc\n"),
              HasSubstr("a.pcd:13: 'abc'; expected a number"));
  EXPECT_THAT(error(Header("ascii", 2, kXyz) + "1 2 3\n"), HasSubstr("only 1 points"));
  EXPECT_THAT(error(Header("ascii", 2, kXyz) + "1.25 2.5 3.5\n"), HasSubstr("after 1 points"));
  EXPECT_THAT(error(Header("ascii", 1, "FIELDS x y\nSIZE 4 4\nTYPE F F\n") + "1 2\n"),
              HasSubstr("no field 'z'"));
  EXPECT_THAT(error(Header("ascii", 1, "FIELDS x y z\nSIZE 4 4\nTYPE F F F\n") + "1 2 3\n"),
              HasSubstr("3 FIELDS, 2 SIZE"));
  EXPECT_THAT(error(Header("ascii", 1, "FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\n") + "1 2 3\n"),
              HasSubstr("SIZE 3"));
  EXPECT_THAT(error(Header("zip", 1, kXyz) + "1 2 3\n"), HasSubstr("ascii, binary"));
}

TEST(PcdReader, RefusesBadCompression) {
  const TempDir dir;
  const std::string header = Header("binary_compressed", 4, kXyz);
  const auto error = [&](const std::string& bytes) { return ReadError(dir.File("a.pcd", bytes)); };
  std::string sizes;
  Append(sizes, std::uint32_t{100}), Append(sizes, std::uint32_t{48});
  EXPECT_THAT(error(header + sizes + "xyz"), HasSubstr("only 3 compressed bytes"));
  std::string huge;
  Append(huge, std::uint32_t{4}), Append(huge, std::uint32_t{3'840'000'000});
  EXPECT_THAT(error(Header("binary_compressed", 320'000'000, kXyz) + huge + "1234"),
              HasSubstr("4 compressed bytes for 3840000000 bytes"));
  std::string wrong = Compressed(std::string(48, 'a'));
  wrong.back() = '\x1f';  // copies from before the beginning
  EXPECT_THAT(error(header + wrong), HasSubstr("damaged LZF data"));
}

TEST(PcdReader, SurvivesDamage) {
  std::string records;
  std::string columns;
  for (int i = 0; i < 20; ++i) AppendRich(records, i, 2, 3, 77, 5);
  ExpectSafeWhenDamaged(Header("binary", 20, kRich) + records, "b.pcd");
  for (int i = 0; i < 15; ++i) Append(columns, static_cast<float>(i));
  ExpectSafeWhenDamaged(Header("binary_compressed", 5, kXyz) + Compressed(columns), "c.pcd");
  ExpectSafeWhenDamaged(Header("ascii", 3, kXyz) + "1 2 3\n4 5 6\n7.5 8.5 9.5\n", "a.pcd");
}

}  // namespace
}  // namespace backsight
