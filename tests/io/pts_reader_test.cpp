#include "io/pts_reader.h"

#include <gmock/gmock.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST(PtsReader, ReadsCountIntensityAndColour) {
  const TempDir dir;
  for (const std::string text :
       {"2\n1 2 3 -2048 255 0 1\n4 5 6.5 2047 9 9 9\n",
        "2\r\n1 2 3 -2048 255 0 1\r\n4 5 6.5 2047 9 9 9",
        "# from a scanner\nX Y Z I R G B\n\n2\n1 2 3 -2048 255 0 1\n\n4 5 6.5 2047 9 9 9\n\n"}) {
    const auto scan = ReadWhole(dir.File("a.pts", text));
    EXPECT_EQ(scan.info.format, "PTS");
    EXPECT_EQ(scan.info.point_count, 2U);
    EXPECT_EQ(scan.info.scan_count, 1);
    EXPECT_EQ(scan.points.z, (std::vector<double>{3, 6.5}));
    EXPECT_EQ(scan.points.intensity, (std::vector<float>{0.0F, 1.0F}));
    EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{65535, 0, 257}));
    EXPECT_THAT(scan.info.notes,
                Contains(HasSubstr("x y z intensity(-2048 to 2047) red(0 to 255)")));
  }
}

TEST(PtsReader, ReadsPointsWithoutAttributes) {
  const TempDir dir;
  const auto bare = ReadWhole(dir.File("a.pts", "2\n1 2 3\nnan 5 6\n"));
  EXPECT_FALSE(bare.info.has_intensity);
  EXPECT_EQ(bare.tally.not_finite, 1U);
  EXPECT_EQ(bare.points.size(), 1U);
  EXPECT_TRUE(ReadWhole(dir.File("b.pts", "1\n1 2 3 -700\n")).info.has_intensity);
  const auto empty = ReadWhole(dir.File("c.pts", "0\n"));
  EXPECT_EQ(empty.info.point_count, 0U);
  EXPECT_EQ(empty.points.size(), 0U);
  EXPECT_EQ(ReadWhole(dir.File("d.pts", "1 2 3\n")).info.format, "XYZ");
}

TEST(PtsReader, ReadsSeveralScans) {
  const TempDir dir;
  const std::string path =
      dir.File("a.pts", "2\n1 1 1 0.5\n2 2 2 0.25\n\n1\n3 3 3 -5 255 0 0\n0\n1\n7 8 9\n");
  const auto first = ReadWhole(path, 0);
  EXPECT_EQ(first.info.scan_count, 4);
  EXPECT_EQ(first.points.x, (std::vector<double>{1, 2}));
  EXPECT_EQ(first.points.intensity, (std::vector<float>{0.5F, 0.25F}));
  const auto second = ReadWhole(path, 1);
  EXPECT_EQ(second.info.scan_index, 1);
  EXPECT_TRUE(second.info.has_rgb);
  EXPECT_EQ(second.points.x, std::vector<double>{3});
  EXPECT_EQ(ReadWhole(path, 2).points.size(), 0U);
  EXPECT_EQ(ReadWhole(path, 3).points.z, std::vector<double>{9});
  EXPECT_THAT(ReadError(path, 4), HasSubstr("scan_index from 0 to 3"));
  EXPECT_THAT(ReadError(path, -1), HasSubstr("scan_index from 0 to 3"));
}

TEST(PtsReader, ReadsAnyNumberOfScansOfAnyWidth) {
  const TempDir dir;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    std::string text;
    std::vector<PointChunk> scans(1 + random.Index(4));
    for (PointChunk& scan : scans) {
      const std::uint64_t n = 1 + random.Index(50);
      const std::uint64_t width = 3 + random.Index(3) * 2;  // 3: bare, 5: (skipped), 7: colour
      text += std::to_string(n) + "\n";
      for (std::uint64_t i = 0; i < n; ++i) {
        scan.x.push_back(static_cast<double>(random.Index(2000000)) / 1024.0 - 900.0);
        text += std::to_string(scan.x.back()) + " -1.5 2";
        if (width > 3) {
          text += ' ';
          text += std::to_string(static_cast<int>(random.Index(4096)) - 2048);
        }
        for (std::uint64_t k = 4; k < width; ++k) text += " 7";
        text += "\n";
      }
    }
    const std::string path = dir.File("a.pts", text);
    for (std::size_t s = 0; s < scans.size(); ++s) {
      const auto read = ReadWhole(path, static_cast<int>(s));
      EXPECT_EQ(read.info.scan_count, static_cast<int>(scans.size()));
      ASSERT_EQ(read.points.size(), scans[s].x.size());
      for (std::size_t i = 0; i < scans[s].x.size(); ++i) {
        ASSERT_NEAR(read.points.x[i], scans[s].x[i], 0.501e-6);  // std::to_string has 6 decimals
      }
    }
  }
}

TEST(PtsReader, ReadsAcrossChunks) {
  const TempDir dir;
  std::string text = "140000\n";
  for (int i = 0; i < 140000; ++i) text += std::to_string(i) + " 1 2\n";
  const auto scan = ReadWhole(dir.File("a.pts", text));
  EXPECT_EQ(scan.chunks, 9U);
  EXPECT_EQ(scan.points.x.back(), 139999.0);
}

TEST(PtsReader, NamesWhatIsWrong) {
  const TempDir dir;
  const auto error = [&](const std::string& text) { return ReadError(dir.File("a.pts", text)); };
  EXPECT_THAT(error("3\n1 2 3\n4 5 6\n"),
              HasSubstr("ends after 2 points; expected the declared 3 points (line 1)"));
  EXPECT_THAT(error("1\n1 2 3\n4 5 6\n"),
              HasSubstr("a.pts:3: '4 5 6'; expected the number of points of another scan"));
  EXPECT_THAT(error("3\n1 2 3\n4 5 6\n1\n7 8 9\n"), HasSubstr("a.pts:5: '7 8 9'"));
  EXPECT_THAT(error("2\n1 2 3\n4 garbage 6\n"), HasSubstr("a.pts:3: 'garbage'"));
  EXPECT_THAT(error("2\n1 2 3\n4 5 6 7\n"), HasSubstr("a.pts:3: 4 values"));
  EXPECT_THAT(error("1000000000000000000\n1 2 3\n"), HasSubstr("1000000000000000000 points"));
}

TEST(PtsReader, DamageBehindCostsOnlyTheScansBehind) {
  const TempDir dir;
  const std::string path = dir.File("a.pts", "1\n1 2 3\n2\n4.25 5.25 6.25\n");
  const auto scan = ReadWhole(path, 0);
  EXPECT_EQ(scan.points.size(), 1U);
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("damaged behind this scan")));
  EXPECT_THAT(ReadError(path, 1), HasSubstr("declared 2 points (line 3)"));
}

TEST(PtsReader, SurvivesDamage) {
  std::string text = "6\n";
  for (int i = 0; i < 6; ++i) text += "1.5 2.5 -3.5 -1000 1 2 3\n";
  ExpectSafeWhenDamaged(text + "2\n1 2 3 4\n5 6 7 8\n", "a.pts");
}

}  // namespace
}  // namespace backsight
