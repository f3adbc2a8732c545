#include <gmock/gmock.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string Repeat(const std::string& line, int n) {
  std::string text;
  for (int i = 0; i < n; ++i) text += line;
  return text;
}

TEST(XyzReader, ReadsAllSeparators) {
  const TempDir dir;
  for (const std::string text :
       {"1 -2 3.5\n4 5 6\n", "1\t-2\t3.5\n4\t5\t6", "1,-2,3.5\r\n4, 5 , 6,\r\n",
        "1;-2;3.5\n4; 5; 6\n", "  1   -2  3.5  \n\n4 5 6\n\n",
        "\xEF\xBB\xBF"
        "1 -2 3.5\n4 5 6\n",
        "# made by hand\n1 -2 3.5\n// in between\n4 5 6\n", "X,Y,Z\n1,-2,3.5\n4,5,6\n"}) {
    const auto scan = ReadWhole(dir.File("a.xyz", text));
    EXPECT_EQ(scan.info.format, "XYZ");
    EXPECT_EQ(scan.points.x, (std::vector<double>{1, 4})) << text;
    EXPECT_EQ(scan.points.y, (std::vector<double>{-2, 5})) << text;
    EXPECT_EQ(scan.points.z, (std::vector<double>{3.5, 6})) << text;
    EXPECT_FALSE(scan.info.has_intensity);
    EXPECT_FALSE(scan.info.has_rgb);
  }
}

TEST(XyzReader, RefusesAFileWhoseFirstRecordIsDamagedWhenItIsOpened) {
  const TempDir dir;
  for (const std::string first : {"1 2 x\n", "1 2 3x 4\n"}) {
    const std::string path = dir.File("a.xyz", first + Repeat("1 2 3\n", 20) + "\n1 2 3\n");
    EXPECT_THAT(ErrorOf([&] { OpenScan(path); }), HasSubstr("a.xyz:1: ")) << first;
  }
}

TEST(XyzReader, GuessesIntensity) {
  const TempDir dir;
  const auto first = [&](const std::string& text, const std::string& name = "a.xyz") {
    const auto scan = ReadWhole(dir.File(name, text));
    EXPECT_TRUE(scan.info.has_intensity);
    EXPECT_THAT(scan.info.notes.back(), HasSubstr("x y z intensity"));
    return scan.points.intensity.at(0);
  };
  EXPECT_FLOAT_EQ(first("1 2 3 0.25\n1 2 3 1\n"), 0.25F);
  EXPECT_FLOAT_EQ(first("1 2 3 51\n1 2 3 200\n"), 0.2F);
  EXPECT_FLOAT_EQ(first("1 2 3 13107\n1 2 3 60000\n"), 0.2F);
  EXPECT_FLOAT_EQ(first("1 2 3 -2048\n1 2 3 2047\n"), 0.0F);
  EXPECT_FLOAT_EQ(first("2\n1 2 3 2047\n1 2 3 500\n", "a.pts"), 1.0F);
  EXPECT_FLOAT_EQ(first("1 2 3 -90000\n1 2 3 10000\n"), 0.0F);
  EXPECT_FLOAT_EQ(first("1 2 3 70000\n"), 0.0F);
}

TEST(XyzReader, GuessesColor) {
  const TempDir dir;
  const auto read = [&](const std::string& text) { return ReadWhole(dir.File("a.txt", text)); };
  const std::array<std::uint16_t, 3> red{65535, 0, 257};
  EXPECT_EQ(read("1 2 3 255 0 1\n").points.rgb.at(0), red);
  const auto behind = read("1 2 3 0.5 255 0 1\n1 2 3 0.7 9 9 9\n");
  EXPECT_EQ(behind.points.rgb.at(0), red);
  EXPECT_FLOAT_EQ(behind.points.intensity.at(0), 0.5F);
  const auto before = read("1 2 3 255 0 1 0.5\n1 2 3 9 9 9 0.25\n");
  EXPECT_EQ(before.points.rgb.at(0), red);
  EXPECT_FLOAT_EQ(before.points.intensity.at(0), 0.5F);
  EXPECT_EQ(read("1 2 3 65535 0 257\n").points.rgb.at(0), red);
  const auto normals = read("1 2 3 0.5 -0.5 0.7\n");
  EXPECT_FALSE(normals.info.has_rgb);
  EXPECT_THAT(normals.info.notes.back(), HasSubstr("x y z (skipped) (skipped) (skipped)"));
}

TEST(XyzReader, GoesByNamesWhereThereAreAny) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File(
      "a.csv", "\"R\",\"G\",\"B\",\"x\",\"y\",\"z\",\"Intensity\"\n1,0,0.5,10,20,30,0.75\n"));
  EXPECT_EQ(scan.points.x, std::vector<double>{10});
  EXPECT_EQ(scan.points.z, std::vector<double>{30});
  EXPECT_EQ(scan.points.intensity, std::vector<float>{0.75F});
  EXPECT_EQ(scan.points.rgb.at(0), (std::array<std::uint16_t, 3>{65535, 0, 32768}));
  const auto comment = ReadWhole(dir.File("b.asc", "//Z Y X\n1 2 3\n"));
  EXPECT_EQ(comment.points.x, std::vector<double>{3});
}

TEST(XyzReader, UnderstandsTheNamesOfSurveyors) {
  const TempDir dir;
  for (const std::string header :
       {"Northing,Easting,Height", "N;E;H", "Hochwert Rechtswert Hoehe", "hw,rw,H\xC3\x96HE",
        "nord,ost,alt", "Northing [m],Easting [m],Elevation [m]", "# north east elev",
        "// Y X ALTITUDE", "# Northing,Easting,Height\n# made by hand"}) {
    const auto scan = ReadWhole(dir.File("a.csv", header + "\n1,2,3\n4,5,6\n"));
    EXPECT_EQ(scan.points.x, (std::vector<double>{2, 5})) << header;
    EXPECT_EQ(scan.points.y, (std::vector<double>{1, 4})) << header;
    EXPECT_EQ(scan.points.z, (std::vector<double>{3, 6})) << header;
    EXPECT_THAT(scan.info.notes.back(), HasSubstr("y x z, by the names in line 1")) << header;
  }
  const auto named =
      ReadWhole(dir.File("a.pts", "Code Northing Easting Height I\n1\n17 1 2 3 0.5\n"));
  EXPECT_EQ(named.points.x, std::vector<double>{2});
  EXPECT_EQ(named.points.intensity, std::vector<float>{0.5F});
}

TEST(XyzReader, ColumnsWithoutAMeaningMayHoldAnything) {
  const TempDir dir;
  const auto scan =
      ReadWhole(dir.File("a.csv", "pt,Northing,Easting,Height\nP1,1,2,3\n#2,4,5,6\n"));
  EXPECT_EQ(scan.points.x, (std::vector<double>{2, 5}));
}

TEST(XyzReader, RefusesToGuessAgainstNames) {
  const TempDir dir;
  for (const auto& [header, found] : std::vector<std::pair<std::string, std::string>>{
           {"Northing,Easting,Elevation_ft", "'Northing', which is y, over the column of x"},
           {"lat,lon,h", "'lat' over the column of x"},
           {"id,x,y", "'id' over the column of x"},
           {"R,H,Z", "'R' over the column of x"},
           {"code,status,north", "'north', which is y, over the column of z"},
           {"# Northing Easting undulation", "'Northing', which is y"},
           {"# columns: N E H", "'N' before 'E'"}}) {
    const std::string error = ReadError(dir.File("a.csv", header + "\n1,2,3\n"));
    EXPECT_THAT(error, HasSubstr("a.csv:1: the names")) << header;
    EXPECT_THAT(error, HasSubstr(found)) << header;
    EXPECT_THAT(error, HasSubstr("with the key columns")) << header;
  }
  using enum TextColumn;
  const auto given = ReadWhole(dir.File("a.csv", "lat,lon,h\n1,2,3\n"), 0, {kY, kX, kZ});
  EXPECT_EQ(given.points.x, std::vector<double>{2});
}

TEST(XyzReader, SaysThatNamesWereNotUnderstood) {
  const TempDir dir;
  const auto notes = [&](const std::string& header) {
    const auto scan = ReadWhole(dir.File("a.csv", header + "\n1,2,3\n"));
    EXPECT_EQ(scan.points.x, std::vector<double>{1}) << header;
    std::string text;
    for (const std::string& note : scan.info.notes) text += note + "\n";
    return text;
  };
  EXPECT_THAT(notes("alpha,beta,gamma"),
              HasSubstr("line 1 ('alpha beta gamma') mean nothing here: the first columns are "
                        "taken as x, y and z"));
  EXPECT_THAT(notes("x,y,gamma"), HasSubstr("do not name every coordinate"));
  EXPECT_THAT(notes("points"), HasSubstr("mean nothing here"));
  // Comments are prose.
  for (const std::string comment : {"# by N. Smith", "# scan of E", "// made in May"}) {
    EXPECT_THAT(notes(comment), Not(HasSubstr("names in line"))) << comment;
  }
}

TEST(XyzReader, LabelsPointToTheKeyForColumns) {
  const TempDir dir;
  const auto error = ReadError(dir.File("a.txt", "pt1 1 2 3\npt2 1 2 3\n"));
  EXPECT_THAT(error, HasSubstr("a.txt:2: 'pt2' (line 1 was taken as header); expected a number"));
  EXPECT_THAT(error, HasSubstr("columns: [skip, x, y, z]"));
}

TEST(XyzReader, TakesGivenColumns) {
  using enum TextColumn;
  const TempDir dir;
  // By its values 40 50 60 would be the colour and 7 the intensity.
  const std::string text = "10 20 30 40 50 60 7\n11 21 31 41 51 61 8\n";
  const auto scan =
      ReadWhole(dir.File("a.xyz", text), 0, {kIntensity, kZ, kY, kX, kSkip, kSkip, kSkip});
  EXPECT_EQ(scan.points.x, (std::vector<double>{40, 41}));
  EXPECT_EQ(scan.points.y, (std::vector<double>{30, 31}));
  EXPECT_EQ(scan.points.z, (std::vector<double>{20, 21}));
  EXPECT_FLOAT_EQ(scan.points.intensity.at(0), 10.0F / 255.0F);
  EXPECT_FALSE(scan.info.has_rgb);
  EXPECT_THAT(scan.info.notes.back(), HasSubstr("z y x (skipped) (skipped) (skipped), as given"));

  const auto colour =
      ReadWhole(dir.File("a.pts", "1\n1 2 3 0 255 255\n"), 0, {kX, kY, kZ, kBlue, kGreen, kRed});
  EXPECT_EQ(colour.info.format, "PTS");
  EXPECT_EQ(colour.points.rgb.at(0), (std::array<std::uint16_t, 3>{65535, 65535, 0}));

  // Given columns outrank the names of a header.
  const auto named = ReadWhole(dir.File("a.csv", "x,y,z\n1,2,3\n"), 0, {kZ, kY, kX});
  EXPECT_EQ(named.points.x, std::vector<double>{3});
}

TEST(XyzReader, SkippedColumnsMayHoldAnything) {
  using enum TextColumn;
  const TempDir dir;
  for (const std::string header : {"", "name,x,y,z\n"}) {
    const auto scan = ReadWhole(dir.File("a.csv", header + "P1,1,2,3,12:30\nP2,4,5,6,\"\"\n"), 0,
                                {kSkip, kX, kY, kZ, kSkip});
    EXPECT_EQ(scan.points.x, (std::vector<double>{1, 4})) << header;
  }
}

TEST(XyzReader, ALabelIsNoComment) {
  using enum TextColumn;
  const TempDir dir;
  const TextColumns columns{kSkip, kX, kY, kZ};
  const auto scan = ReadWhole(
      dir.File("a.xyz", "# 1 by hand\n#1 1 2 3\n//2 4 5 6\n# x y z\nP3 7 8 9\n"), 0, columns);
  EXPECT_EQ(scan.points.x, (std::vector<double>{1, 4, 7}));
}

TEST(XyzReader, GivenColumnsMustFit) {
  using enum TextColumn;
  const TempDir dir;
  const auto error = [&](const std::string& name, const std::string& text) {
    const std::string path = dir.File(name, text);
    return ErrorOf([&] { ReadWhole(path, 0, {kX, kY, kZ, kSkip}); });
  };
  EXPECT_THAT(error("a.xyz", "1 2 3\n"), HasSubstr("a.xyz:1: 3 values"));
  EXPECT_THAT(error("a.xyz", "1 2 3 4\n1 2 3 4 5\n"), HasSubstr("a.xyz:2: 5 values"));
  EXPECT_THAT(error("a.xyz", "1 2 3 4\n1 b 3 4\n"), HasSubstr("'b'; expected a number"));
  EXPECT_THAT(error("a.pts", "1\n1 2 3\n"), HasSubstr("expected 4 values"));
  EXPECT_THAT(error("a.pcd", "# .PCD v0.7\n"), HasSubstr("says itself what it holds"));
}

TEST(XyzReader, ColumnsOfTheCommandLine) {
  using enum TextColumn;
  EXPECT_EQ(ParseTextColumns("x, y,z ,skip,r,g,b,intensity", "--columns"),
            (TextColumns{kX, kY, kZ, kSkip, kRed, kGreen, kBlue, kIntensity}));
  const auto error = [](const std::string& list) {
    return ErrorOf([&] { ParseTextColumns(list, "--columns"); });
  };
  EXPECT_THAT(error("x,y"), HasSubstr("--columns: no z"));
  EXPECT_THAT(error(""), HasSubstr("no x"));
  EXPECT_THAT(error("x,y,z,x"), HasSubstr("x twice"));
  EXPECT_THAT(error("x,y,z,r"), HasSubstr("1 of r, g and b"));
  EXPECT_THAT(error("x,y,z,red"), HasSubstr("'red'"));
}

TEST(TextColumns, AreNoMoreThanAReaderTakes) {
  std::string list = "x,y,z";
  for (std::size_t i = 3; i < kMaxTextColumns; ++i) list += ",skip";
  EXPECT_EQ(ParseTextColumns(list, "--columns").size(), kMaxTextColumns);
  EXPECT_THROW(ParseTextColumns(list + ",skip", "--columns"), InputError);
}

TEST(XyzReader, DropsWhatIsNotFinite) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File("a.xyz", "nan nan nan\n1 2 inf\n1 2 3\n-inf 0 0\n0 0 0\n"));
  EXPECT_EQ(scan.tally.not_finite, 3U);
  EXPECT_EQ(scan.tally.no_return, 0U);
  EXPECT_EQ(scan.points.size(), 2U);
}

TEST(XyzReader, ReadsAcrossChunks) {
  const TempDir dir;
  std::string text;
  for (int i = 0; i < 131073; ++i) text += std::to_string(i) + ".5 0 0 -100 1 2 3\n";
  const auto scan = ReadWhole(dir.File("a.xyz", text));
  EXPECT_EQ(scan.chunks, 9U);
  EXPECT_FALSE(scan.info.point_count);
  EXPECT_EQ(scan.points.x.back(), 131072.5);
  EXPECT_TRUE(scan.info.has_rgb);
}

TEST(XyzReader, NotesValuesBeyondTheGuess) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File("a.xyz", Repeat("1 2 3 0.5\n", 3000) + "1 2 3 99\n"));
  EXPECT_EQ(scan.points.intensity.back(), 1.0F);
  EXPECT_THAT(scan.tally.notes.at(0), HasSubstr("clamped in 1 of 3001"));
}

TEST(XyzReader, NamesWhatIsWrong) {
  const TempDir dir;
  const auto error = [&](const std::string& bytes) { return ReadError(dir.File("a.xyz", bytes)); };
  EXPECT_THAT(error("1 2 3\n4 5 6\n7 8 x9\n"), HasSubstr("a.xyz:3: 'x9'; expected a number"));
  EXPECT_THAT(error("1 2 3\n4 5\n"), HasSubstr("a.xyz:2: 2 values"));
  EXPECT_THAT(error(Repeat("1 2 3\n", 100000) + "4 5\n"), HasSubstr("a.xyz:100001: 2 values"));
  EXPECT_THAT(error("1,5 2,5 3,5\n"), HasSubstr("decimal point"));
  EXPECT_THAT(error("1,5;2,5;3,5\n"), HasSubstr("decimal point"));
  EXPECT_THAT(error("1,,3\n"), HasSubstr("''; expected a number"));
  EXPECT_THAT(error("1 2 1e999\n"), HasSubstr("'1e999'"));
  EXPECT_THAT(error("head one\nhead two\n1 2 3\n"), HasSubstr("a.xyz:2"));
  EXPECT_THAT(error("# nothing\n\n"), HasSubstr("ends without a point"));
  EXPECT_THAT(error("1 2 3\n" + std::string(200000, '7') + "\n"), HasSubstr("a.xyz:2: a line"));
  EXPECT_THAT(error(std::string(3000, '\0')), HasSubstr("a.xyz:1: 1 values: '\\x00\\x00"));
}

TEST(XyzReader, SurvivesDamage) {
  ExpectSafeWhenDamaged("x y z i r g b\n" + Repeat("1.5 2.5 -3.5 -100 1 2 3\n", 8), "a.xyz");
  ExpectSafeWhenDamaged(Repeat("1.5,2.5,-3.5,0.5\n", 5), "a.pts");
}

}  // namespace
}  // namespace backsight
