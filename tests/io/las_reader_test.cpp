#include "io/las_reader.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/io/las_bytes.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr unsigned kAdjustedTime = 1;
constexpr unsigned kWkt = 16;

void ExpectSame(const WholeScan& scan, const LasTestFile& file) {
  std::size_t k = 0;
  std::uint64_t withheld = 0;
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const LasTestPoint& point = file.points[i];
    if (point.withheld) {
      ++withheld;
      continue;
    }
    ASSERT_LT(k, scan.points.size());
    ASSERT_EQ(scan.points.x[k], file.Coordinate(i, 0));
    ASSERT_EQ(scan.points.y[k], file.Coordinate(i, 1));
    ASSERT_EQ(scan.points.z[k], file.Coordinate(i, 2));
    ASSERT_EQ(scan.points.intensity[k], static_cast<float>(point.intensity / 65535.0));
    ASSERT_EQ(scan.points.classification[k], point.classification);
    if (file.HasRgb()) {
      ASSERT_EQ(scan.points.rgb[k], point.rgb);
    }
    if (file.HasGpsTime()) {
      ASSERT_EQ(scan.points.gps_time[k], point.gps_time);
    }
    ++k;
  }
  EXPECT_EQ(scan.points.size(), k);
  EXPECT_EQ(scan.tally.withheld, withheld);
  EXPECT_EQ(scan.info.point_count, file.points.size());
}

/// Everything about a file at random that the format leaves open.
LasTestFile RandomFile(int format, std::uint64_t seed) {
  Random random(seed * 100 + static_cast<std::uint64_t>(format));
  LasTestFile file;
  file.format = format;
  file.minor = format < 6 ? 1 + static_cast<int>(random.Index(5)) : 4 + static_cast<int>(seed % 2);
  file.encoding = kAdjustedTime;
  file.extra_header_bytes = random.Index(3) * 7;
  file.extra_point_bytes = random.Index(3) * 11;
  for (std::size_t a = 0; a < 3; ++a) {
    file.scale[a] = random.Uniform(1e-5, 1e-2);
    file.offset[a] = random.Uniform(-1e7, 1e7);
  }
  for (std::uint64_t i = random.Index(4); i > 0; --i) {
    file.records.push_back(LasTestRecord("somebody", 7, std::string(random.Index(500), 'r')));
  }
  for (std::uint64_t i = file.minor >= 4 ? random.Index(3) : 0; i > 0; --i) {
    file.extended.push_back(
        LasTestRecord("somebody", 7, std::string(random.Index(500), 'e'), true));
  }
  file.points = RandomLasPoints(format, 500 + random.Index(500), random);
  return file;
}

class LasFormats : public ::testing::TestWithParam<int> {};

TEST_P(LasFormats, AreReadWithAllTheirFields) {
  const TempDir dir;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const LasTestFile file = RandomFile(GetParam(), seed);
    const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
    EXPECT_EQ(scan.info.format, "LAS 1." + std::to_string(file.minor));
    EXPECT_TRUE(scan.info.has_intensity);
    EXPECT_EQ(scan.info.has_rgb, file.HasRgb());
    EXPECT_EQ(scan.info.has_gps_time, file.HasGpsTime());
    EXPECT_FALSE(scan.info.world_from_scan);
    EXPECT_THAT(scan.info.notes, IsEmpty());
    ExpectSame(scan, file);
  }
}

TEST_P(LasFormats, SurviveDamage) {
  LasTestFile file = RandomFile(GetParam(), 3);
  file.points.resize(20);
  file.records = {LasTestRecord("LASF_Projection", 2112, "PROJCS[\"somewhere\"]"),
                  LasTestRecord("LASF_Projection", 34735, GeoKeyBytes({{3072, 0, 1, 25832}}))};
  ExpectSafeWhenDamaged(file.Bytes(), "a.las", 60);
}

INSTANTIATE_TEST_SUITE_P(All, LasFormats, ::testing::Range(0, 11));

LasTestFile SmallFile(int minor = 4, int format = 7, std::size_t n = 3) {
  Random random(1);
  LasTestFile file;
  file.minor = minor;
  file.format = format;
  file.encoding = kAdjustedTime;
  file.points = RandomLasPoints(format, n, random);
  for (LasTestPoint& point : file.points) point.synthetic = point.withheld = false;
  return file;
}

TEST(LasReader, SurvivesAnyByteOfTheHeader) {
  const TempDir dir;
  LasTestFile file = RandomFile(7, 4);
  file.points.resize(5);
  const std::string good = file.Bytes();
  for (std::size_t at = 0; at < file.HeaderBytes() + 60; ++at) {
    for (const char value : {'\x00', '\x01', '\xff'}) {
      std::string damaged = good;
      damaged[at] = value;
      try {
        const auto scan = ReadWhole(dir.File("a.bin", damaged));
        EXPECT_EQ(scan.tally.records, scan.info.point_count) << at;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("a.bin")) << at;
      }
    }
  }
}

TEST(LasReader, ReadsAcrossChunks) {
  const TempDir dir;
  const LasTestFile file = SmallFile(2, 2, 140000);
  const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_EQ(scan.chunks, 9U);
  ExpectSame(scan, file);
}

TEST(LasReader, ReadsAnEmptyCloud) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File("a.las", SmallFile(4, 6, 0).Bytes()));
  EXPECT_EQ(scan.info.point_count, 0U);
  EXPECT_EQ(scan.points.size(), 0U);
}

TEST(LasReader, DropsWithheldAndKeepsSyntheticPoints) {
  const TempDir dir;
  for (const int format : {1, 6}) {
    LasTestFile file = SmallFile(4, format);
    file.points[0].withheld = true;
    file.points[1].synthetic = true;
    const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
    EXPECT_EQ(scan.points.size(), 2U);
    EXPECT_EQ(scan.tally.withheld, 1U);
    EXPECT_THAT(scan.tally.notes, Contains(HasSubstr("1 points flagged as synthetic are kept")));
  }
  // LAS 1.0 has no flags: the whole byte is the class.
  LasTestFile file = SmallFile(0, 1);
  for (LasTestPoint& point : file.points) point.classification = 200;
  const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_EQ(scan.points.classification, (std::vector<std::uint8_t>{200, 200, 200}));
}

TEST(LasReader, FindsValuesOfEightBitsAndSaysSo) {
  const TempDir dir;
  LasTestFile file = SmallFile();
  for (LasTestPoint& point : file.points) {
    point.intensity = 51;
    point.rgb = {255, 0, 1};
  }
  const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_EQ(scan.points.rgb[0], (std::array<std::uint16_t, 3>{65535, 0, 257}));
  EXPECT_FLOAT_EQ(scan.points.intensity[0], 0.2F);
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("colours are <= 255: taken as 8 bit")));
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("intensity is <= 51: taken as 8 bit")));
  file.points[2].rgb = {256, 0, 0};
  EXPECT_EQ(ReadWhole(dir.File("a.las", file.Bytes())).points.rgb[0],
            (std::array<std::uint16_t, 3>{255, 0, 1}));
}

TEST(LasReader, SaysWhereTheSampleWasWrong) {
  const TempDir dir;
  LasTestFile file = SmallFile(2, 2, 200000);
  for (LasTestPoint& point : file.points) {
    point.intensity = 100;
    point.rgb = {9, 9, 9};
  }
  file.points[5000].intensity = 300;  // between two of the 32 runs of 2048
  file.points[5000].rgb = {300, 9, 9};
  const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_EQ(scan.points.rgb[5000][0], 65535);
  EXPECT_THAT(scan.tally.notes, Contains(HasSubstr("colour above 255 clamped in 1 points")));
  EXPECT_THAT(scan.tally.notes, Contains(HasSubstr("intensity outside 0 to 255 clamped in 1")));
}

TEST(LasReader, TakesZerosForFieldsThatAreNotUsed) {
  const TempDir dir;
  LasTestFile file = SmallFile();
  for (LasTestPoint& point : file.points) point.intensity = 0, point.rgb = {};
  const auto scan = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_FALSE(scan.info.has_intensity);
  EXPECT_FALSE(scan.info.has_rgb);
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("intensity is 0: taken as not recorded")));
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("colours are 0: taken as not recorded")));
}

TEST(LasReader, GivesGpsTimesInOneForm) {
  const TempDir dir;
  LasTestFile file = SmallFile(5);
  file.encoding = 0;
  for (LasTestPoint& point : file.points) point.gps_time = 25.5;
  const auto week = ReadWhole(dir.File("a.las", file.Bytes()));
  EXPECT_FALSE(week.info.has_gps_time);
  EXPECT_THAT(week.info.notes, Contains(HasSubstr("GPS times lack their week")));
  file.encoding = kAdjustedTime;
  EXPECT_EQ(ReadWhole(dir.File("a.las", file.Bytes())).points.gps_time[0], 25.5);
  file.encoding = kAdjustedTime | 64U;  // LAS 1.5: seconds minus this many million
  file.time_offset = 1500;
  EXPECT_EQ(ReadWhole(dir.File("a.las", file.Bytes())).points.gps_time[0], 5e8 + 25.5);
}

TEST(LasReader, NotesBoundsThatAreNotThoseOfThePoints) {
  const TempDir dir;
  std::string bytes = SmallFile().Bytes();
  StoreBytes(bytes.data() + 179 + 16, 1e9);
  EXPECT_THAT(ReadWhole(dir.File("a.las", bytes)).tally.notes,
              Contains(HasSubstr("the header bounds axis 1 by")));
}

TEST(LasReader, RepairsCountsThatDisagree) {
  const TempDir dir;
  const auto read = [&](std::uint64_t count, std::uint32_t legacy) {
    std::string bytes = SmallFile(4, 7).Bytes();
    StoreBytes(bytes.data() + 247, count);
    StoreBytes(bytes.data() + 107, legacy);
    return ReadWhole(dir.File("a.las", bytes));
  };
  EXPECT_THAT(read(3, 3).info.notes, IsEmpty());
  for (const auto& [count, legacy] :
       {std::pair{0ULL, 3U}, {3ULL, 7U}, {2ULL, 3U}, {UINT64_MAX, 3U}, {99ULL, 3U}}) {
    const auto scan = read(count, legacy);
    EXPECT_EQ(scan.points.size(), 3U) << count << " " << legacy;
    EXPECT_THAT(scan.info.notes, Contains(HasSubstr("3 taken")));
  }
  const auto fewer = read(2, 0);
  EXPECT_EQ(fewer.points.size(), 2U);
  EXPECT_THAT(fewer.info.notes, Contains(HasSubstr("36 bytes behind the last of the 2 declared")));
}

std::string Wkt(bool extended, const std::string& text) {
  return LasTestRecord("LASF_Projection", 2112, text + std::string(1, '\0'), extended);
}

TEST(LasReader, RecordsTheReferenceSystem) {
  const TempDir dir;
  const auto crs = [&](const LasTestFile& file) {
    return ReadWhole(dir.File("a.las", file.Bytes())).info.crs;
  };
  LasTestFile file = SmallFile();
  EXPECT_EQ(crs(file), "");
  file.encoding = kWkt;
  file.records = {LasTestRecord("other", 2112, "no"), Wkt(false, "PROJCS[\"a\"]")};
  EXPECT_EQ(crs(file), "PROJCS[\"a\"]");
  file.records.clear();
  file.extended = {LasTestRecord("other", 1, std::string(70000, 'e'), true),
                   Wkt(true, "PROJCS[\"b\"]")};
  EXPECT_EQ(crs(file), "PROJCS[\"b\"]");
  const std::string keys = LasTestRecord(
      "LASF_Projection", 34735,
      GeoKeyBytes({{1024, 0, 1, 1}, {3072, 0, 1, 25832}, {3073, 34737, 6, 2}, {4096, 0, 1, 7837}}));
  file.records = {keys, LasTestRecord("LASF_Projection", 34737, "a|UTM32N|b|")};
  EXPECT_EQ(crs(file), "PROJCS[\"b\"]");
  file.encoding = 0;
  EXPECT_EQ(crs(file),
            "GeoTIFF: projected EPSG:25832, projected citation 'UTM32N', vertical "
            "EPSG:7837");
}

TEST(LasReader, TurnsCitationsThatKeysCutThroughACharacterIntoText) {
  const TempDir dir;
  LasTestFile file = SmallFile();
  file.records = {LasTestRecord("LASF_Projection", 34735, GeoKeyBytes({{3073, 34737, 3, 2}})),
                  LasTestRecord("LASF_Projection", 34737, "\u00e4\u00f6\u00fc|")};
  EXPECT_EQ(ReadWhole(dir.File("a.las", file.Bytes())).info.crs,
            "GeoTIFF: projected citation '\u00f6?'");
}

TEST(LasReader, WarnsOfUnitsOtherThanMetres) {
  const TempDir dir;
  LasTestFile file = SmallFile();
  const auto notes = [&](const std::string& record) {
    file.records = {record};
    return ReadWhole(dir.File("a.las", file.Bytes())).info.notes;
  };
  const auto keys = [](std::uint16_t key, std::uint16_t value) {
    return LasTestRecord("LASF_Projection", 34735, GeoKeyBytes({{key, 0, 1, value}}));
  };
  EXPECT_THAT(notes(keys(1024, 2)), Contains(HasSubstr("degrees")));
  EXPECT_THAT(notes(keys(3076, 9003)), Contains(HasSubstr("feet")));
  EXPECT_THAT(notes(keys(3076, 9001)), IsEmpty());
  EXPECT_THAT(notes(Wkt(false, "GEOGCS[\"WGS 84\"]")), Contains(HasSubstr("degrees")));
  EXPECT_THAT(notes(Wkt(false, "PROJCS[\"a\",GEOGCS[\"b\"],UNIT[\"US survey foot\",0.3048]]")),
              Contains(HasSubstr("feet")));
  EXPECT_THAT(notes(Wkt(false, "PROJCS[\"a\",GEOGCS[\"b\"],UNIT[\"metre\",1]]")), IsEmpty());
}

TEST(LasReader, LeavesOutRecordsThatRunOutOfTheirPlace) {
  const TempDir dir;
  LasTestFile file = SmallFile();
  file.records = {LasTestRecord("x", 1, "abc"), Wkt(false, "PROJCS[]")};
  file.extended = {Wkt(true, "PROJCS[]")};
  const std::string good = file.Bytes();
  std::string bytes = good;
  StoreBytes<std::uint16_t>(bytes.data() + 375 + 20, 65535);  // length of the first record
  auto scan = ReadWhole(dir.File("a.las", bytes));
  EXPECT_EQ(scan.points.size(), 3U);
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("variable length record 1 of 2 at byte 375")));
  bytes = good;
  StoreBytes<std::uint32_t>(bytes.data() + 100, UINT32_MAX);  // number of records
  scan = ReadWhole(dir.File("a.las", bytes));
  EXPECT_EQ(scan.info.crs, "PROJCS[]");
  EXPECT_THAT(scan.info.notes, Contains(HasSubstr("record 3 of 4294967295")));
  bytes = good;
  const auto extended = LoadBytes<std::uint64_t>(bytes.data() + 235);
  StoreBytes(bytes.data() + extended + 20, UINT64_MAX);  // length of the extended record
  EXPECT_THAT(ReadWhole(dir.File("a.las", bytes)).info.notes,
              Contains(HasSubstr("extended variable length record 1 of 1")));
  bytes = good;
  StoreBytes(bytes.data() + 235, extended - 20);
  EXPECT_THAT(ReadWhole(dir.File("a.las", bytes)).info.notes,
              Contains(HasSubstr("in the middle of the points")));
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{good.size()}, UINT64_MAX}) {
    StoreBytes(bytes.data() + 235, offset);
    EXPECT_THAT(ReadWhole(dir.File("a.las", bytes)).info.notes,
                Contains(HasSubstr("not behind the points")));
  }
}

TEST(LasReader, NamesWhatIsWrong) {
  const TempDir dir;
  const std::string good = SmallFile().Bytes();
  const auto error = [&](std::size_t at, auto value) {
    std::string bytes = good;
    StoreBytes(bytes.data() + at, value);
    return ReadError(dir.File("a.las", bytes));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error(24, std::uint8_t{2}), HasSubstr("a.las: byte 24: LAS version 2.4"));
  EXPECT_THAT(error(25, std::uint8_t{6}), HasSubstr("expected 1.0 to 1.5"));
  EXPECT_THAT(error(94, std::uint16_t{227}), HasSubstr("byte 94: a header of 227 bytes"));
  EXPECT_THAT(error(94, std::uint16_t{9999}), HasSubstr("byte 94: a header of 9999 bytes"));
  EXPECT_THAT(error(96, std::uint32_t{300}), HasSubstr("byte 96: points at byte 300"));
  EXPECT_THAT(error(96, UINT32_MAX), HasSubstr("byte 96: points at byte 4294967295"));
  EXPECT_THAT(error(104, std::uint8_t{11}), HasSubstr("byte 104: point data record format 11"));
  EXPECT_THAT(error(105, std::uint16_t{35}),
              HasSubstr("byte 105: point records of 35 bytes; expected at least 36"));
  for (const double scale : {0.0, -0.001, kNan, HUGE_VAL}) {
    EXPECT_THAT(error(139, scale), HasSubstr("byte 139: scale"));
  }
  EXPECT_THAT(error(171, kNan), HasSubstr("byte 171: offset nan of axis 2"));
  EXPECT_THAT(error(247, std::uint64_t{4}),
              HasSubstr("byte 375: only 3 points are available; expected the declared 4 points"));
  EXPECT_THAT(error(247, UINT64_MAX), HasSubstr("only 3 points are available"));
  for (const std::size_t n : {4UL, 100UL, 226UL, 374UL, 376UL, good.size() - 1}) {
    EXPECT_THAT(ReadError(dir.File("a.las", good.substr(0, n))), HasSubstr("a.las: byte")) << n;
  }
}

}  // namespace
}  // namespace backsight
