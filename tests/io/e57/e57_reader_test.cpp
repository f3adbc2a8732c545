#include "io/e57/e57_reader.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "tests/io/e57/e57_bytes.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kXyzDouble =
    "<cartesianX type='Float'/><cartesianY type='Float'/><cartesianZ type='Float'/>";
constexpr const char* kXyzSingle =
    "<cartesianX type='Float' precision='single'/><cartesianY type='Float' precision='single'/>"
    "<cartesianZ type='Float' precision='single'/>";

WholeScan Read(const TestScan& scan) {
  const TempDir dir;
  return ReadWhole(dir.File("a.e57", Paged(E57Payload({scan}))));
}

std::string ErrorIn(const TestScan& scan) {
  const TempDir dir;
  return ReadError(dir.File("a.e57", Paged(E57Payload({scan}))));
}

std::vector<std::string> Xyz(const std::vector<double>& x) {
  return {PackNumbers(x), PackNumbers(x), PackNumbers(x)};
}

TestScan XyzScan(const std::vector<double>& x, const std::string& before_points = "") {
  return {before_points, kXyzDouble, x.size(), {DataPacket(Xyz(x))}};
}

TEST(E57Reader, ReadsCoordinatesOfEveryCodec) {
  const auto scan = Read(
      {"",
       "<cartesianX type='Float'/><cartesianY type='Float' precision='single'/>"
       "<cartesianZ type='ScaledInteger' minimum='-5' maximum='10' scale='0.25' offset='100'/>",
       3,
       {DataPacket({PackNumbers<double>({0.1, 1e300, -2}), PackNumbers<float>({0.5F, 2.0F, 3.0F}),
                    PackBits(std::vector<std::uint64_t>{0, 15, 5}, 4)})}});
  EXPECT_EQ(scan.info.format, "E57");
  EXPECT_EQ(scan.info.point_count, 3U);
  EXPECT_EQ(scan.info.scan_count, 1);
  EXPECT_FALSE(scan.info.has_intensity);
  EXPECT_FALSE(scan.info.has_rgb);
  EXPECT_THAT(scan.points.x, ElementsAre(0.1, 1e300, -2.0));
  EXPECT_THAT(scan.points.y, ElementsAre(0.5, 2.0, 3.0));
  EXPECT_THAT(scan.points.z, ElementsAre(98.75, 102.5, 100.0));
}

TEST(E57Reader, ReadsSphericalCoordinates) {
  constexpr double kPi = std::numbers::pi;
  const auto scan =
      Read({"",
            "<sphericalAzimuth type='Float'/><sphericalRange type='Float'/>"
            "<sphericalElevation type='Float'/><sphericalInvalidState type='Integer' "
            "minimum='0' maximum='2'/>",
            4,
            {DataPacket({PackNumbers<double>({0, kPi / 2, -kPi, 1}),
                         PackNumbers<double>({2, 3, 4, 5}), PackNumbers<double>({0, 0, kPi / 6, 0}),
                         PackBits(std::vector<std::uint64_t>{0, 0, 0, 2}, 2)})}});
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_EQ(scan.tally.no_return, 1U);
  EXPECT_NEAR(scan.points.x[0], 2.0, 1e-15);
  EXPECT_NEAR(scan.points.y[1], 3.0, 1e-15);
  EXPECT_NEAR(scan.points.x[2], -2.0 * std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(scan.points.z[2], 2.0, 1e-15);
}

TEST(E57Reader, DropsAndCountsWhatIsNoPoint) {
  const double nan = std::nan("");
  TestScan scan = XyzScan({1, 2, nan, 0, 5});
  scan.prototype += "<cartesianInvalidState type='Integer' minimum='0' maximum='2'/>";
  const std::string state = PackBits(std::vector<std::uint64_t>{0, 1, 0, 0, 2}, 2);
  scan.packets = {
      DataPacket({PackNumbers<double>({1, 2, nan, 0, 5}), PackNumbers<double>({1, 2, 3, 0, 5}),
                  PackNumbers<double>({1, 2, 3, 0, 5}), state})};
  const auto cloud = Read(scan);
  EXPECT_EQ(cloud.tally.no_return, 2U);
  EXPECT_EQ(cloud.tally.not_finite, 1U);
  EXPECT_THAT(cloud.points.x, ElementsAre(1.0, 0.0));
}

TEST(E57Reader, ScansWithAGridHaveNoReturnsAtTheOrigin) {
  TestScan scan = XyzScan({1, 0},
                          "<indexBounds type='Structure'><rowMinimum type='Integer'>2</rowMinimum>"
                          "<rowMaximum type='Integer'>4</rowMaximum><columnMinimum type='Integer'/>"
                          "<columnMaximum type='Integer'>6</columnMaximum></indexBounds>");
  const auto flat = Read(scan);
  EXPECT_EQ(flat.info.rows, 0);
  EXPECT_EQ(flat.points.size(), 2U);
  scan.prototype +=
      "<rowIndex type='Integer' minimum='0' maximum='7'/>"
      "<columnIndex type='Integer' minimum='0' maximum='0'/>";
  auto streams = Xyz({1, 0});
  streams.push_back(PackBits(std::vector<std::uint64_t>{2, 4}, 3));
  streams.emplace_back();
  scan.packets = {DataPacket(streams)};
  const auto grid = Read(scan);
  EXPECT_EQ(grid.info.rows, 3);
  EXPECT_EQ(grid.info.columns, 7);
  EXPECT_EQ(grid.tally.no_return, 1U);
  EXPECT_THAT(grid.points.x, ElementsAre(1.0));
  EXPECT_THAT(grid.points.row, ElementsAre(0));  // the grid begins at row 2
  EXPECT_THAT(grid.points.column, ElementsAre(0));
  EXPECT_TRUE(grid.tally.notes.empty());
}

TEST(E57Reader, CellsOutsideTheGridAreMovedToItsEdge) {
  TestScan scan = XyzScan({1, 2, 3},
                          "<indexBounds type='Structure'><rowMinimum type='Integer'>1</rowMinimum>"
                          "<rowMaximum type='Integer'>3</rowMaximum><columnMinimum type='Integer'/>"
                          "<columnMaximum type='Integer'>6</columnMaximum></indexBounds>");
  scan.prototype +=
      "<rowIndex type='Integer' minimum='0' maximum='7'/>"
      "<columnIndex type='Integer' minimum='0' maximum='7'/>";
  auto streams = Xyz({1, 2, 3});
  streams.push_back(PackBits(std::vector<std::uint64_t>{0, 3, 7}, 3));
  streams.push_back(PackBits(std::vector<std::uint64_t>{6, 5, 7}, 3));
  scan.packets = {DataPacket(streams)};
  const auto grid = Read(scan);
  EXPECT_THAT(grid.points.row, ElementsAre(0, 2, 2));
  EXPECT_THAT(grid.points.column, ElementsAre(6, 5, 6));
  ASSERT_EQ(grid.tally.notes.size(), 1U);
  EXPECT_THAT(grid.tally.notes[0], HasSubstr("in 2 of 3 points"));
}

TEST(E57Reader, ScalesIntensityByItsLimits) {
  const std::string field = "<intensity type='Integer' minimum='0' maximum='1000'/>";
  const std::string limits =
      "<intensityLimits type='Structure'><intensityMinimum type='Integer'>100</intensityMinimum>"
      "<intensityMaximum type='Integer'>300</intensityMaximum></intensityLimits>";
  const auto read = [&](const std::string& before, const std::string& prototype,
                        const std::string& stream) {
    auto streams = Xyz({1, 2, 3});
    streams.push_back(stream);
    return Read({before, kXyzDouble + prototype, 3, {DataPacket(streams)}});
  };
  const std::string stream = PackBits(std::vector<std::uint64_t>{100, 250, 300}, 10);
  const auto stated = read(limits, field, stream);
  EXPECT_TRUE(stated.info.has_intensity);
  EXPECT_THAT(stated.points.intensity, ElementsAre(0.0F, 0.75F, 1.0F));
  EXPECT_THAT(read("", field, stream).points.intensity, ElementsAre(0.1F, 0.25F, 0.3F));
  const std::string floats = PackNumbers<float>({0.0F, 0.5F, 2.0F});
  const auto plain = read("", "<intensity type='Float' precision='single'/>", floats);
  EXPECT_THAT(plain.points.intensity, ElementsAre(0.0F, 0.5F, 1.0F));
  EXPECT_THAT(plain.tally.notes.at(0), HasSubstr("clamped in 1"));
  const auto bounded =
      read("", "<intensity type='Float' precision='single' minimum='-2' maximum='2'/>", floats);
  EXPECT_THAT(bounded.points.intensity, ElementsAre(0.5F, 0.625F, 1.0F));
}

TEST(E57Reader, ScalesColourByItsLimits) {
  const auto read = [](const std::string& before, int maximum, unsigned bits) {
    std::string prototype = kXyzDouble;
    for (const char* name : {"Red", "Green", "Blue"}) {
      prototype += "<color" + std::string(name) + " type='Integer' minimum='0' maximum='" +
                   std::to_string(maximum) + "'/>";
    }
    auto streams = Xyz({1, 2});
    for (const std::uint64_t v : {0U, 51U, 255U}) {
      streams.push_back(PackBits(std::vector<std::uint64_t>{v, 1}, bits));
    }
    prototype += "<isColorInvalid type='Integer' minimum='0' maximum='1'/>";
    streams.push_back(PackBits(std::vector<std::uint64_t>{0, 1}, 1));
    return Read({before, prototype, 2, {DataPacket(streams)}}).points.rgb;
  };
  using Rgb = std::array<std::uint16_t, 3>;
  EXPECT_THAT(read("", 255, 8), ElementsAre(Rgb{0, 51 * 257, 65535}, Rgb{0, 0, 0}));
  EXPECT_THAT(read("", 65535, 16), ElementsAre(Rgb{0, 51, 255}, Rgb{0, 0, 0}));
  std::string limits = "<colorLimits type='Structure'>";
  for (const std::string name : {"Red", "Green", "Blue"}) {
    limits += "<color" + name + "Minimum type='Integer'>0</color" + name + "Minimum><color" + name +
              "Maximum type='Integer'>510</color" + name + "Maximum>";
  }
  EXPECT_THAT(read(limits + "</colorLimits>", 65535, 16).at(0), (Rgb{0, 6554, 32768}));
}

TEST(E57Reader, RecordsThePoseAndRepairsItsQuaternion) {
  const auto read = [](const std::string& pose) { return Read(XyzScan({1}, pose)).info; };
  const std::string translation =
      "<translation type='Structure'><x type='Float'>1.5</x><y type='Float'>-2</y>"
      "<z type='Float'/></translation>";
  const auto rotation = [](const std::string& w, const std::string& z) {
    return "<rotation type='Structure'><w type='Float'>" + w +
           "</w><x type='Float'/><y type='Float'/><z type='Float'>" + z + "</z></rotation>";
  };
  const auto pose = [](const std::string& content) {
    return "<pose type='Structure'>" + content + "</pose>";
  };
  EXPECT_TRUE(read("").world_from_scan->Matrix().isIdentity());
  const auto shifted = read(pose(translation));
  EXPECT_EQ(shifted.world_from_scan->translation, Eigen::Vector3d(1.5, -2, 0));
  EXPECT_TRUE(shifted.world_from_scan->rotation.isIdentity());
  EXPECT_TRUE(shifted.notes.empty());
  for (const auto& [w, z, note] :
       {std::array<std::string, 3>{"0.70710678118654757", "0.70710678118654757", ""},
        {"2", "2", "length 2.82843: normalised"},
        {"1e-200", "1e-200", "normalised"},
        {"1e308", "1e308", "normalised"}}) {
    const auto info = read(pose(rotation(w, z) + translation));
    const Eigen::Vector3d x = info.world_from_scan->rotation * Eigen::Vector3d::UnitX();
    EXPECT_NEAR((x - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-15) << w;
    EXPECT_EQ(info.notes.size(), note.empty() ? 0U : 1U);
    EXPECT_THAT(info.notes.empty() ? "" : info.notes.at(0), HasSubstr(note));
  }
  const auto zero = read(pose(rotation("0", "0")));
  EXPECT_TRUE(zero.world_from_scan->Matrix().isIdentity());
  EXPECT_THAT(zero.notes.at(0), HasSubstr("quaternion of zeros"));
}

TEST(E57Reader, ReadsEachScanOfSeveral) {
  const TempDir dir;
  const std::string path =
      dir.File("a.e57", Paged(E57Payload({XyzScan({1, 2},
                                                  "<guid type='String'><![CDATA[{A}]]></guid>"
                                                  "<name type='String'>Hall &amp; yard</name>"),
                                          XyzScan({}), XyzScan(std::vector<double>(2000, 7.0))})));
  const auto first = ReadWhole(path, 0);
  EXPECT_EQ(first.info.scan_count, 3);
  EXPECT_EQ(first.info.guid, "{A}");
  EXPECT_EQ(first.info.name, "Hall & yard");
  EXPECT_THAT(first.points.x, ElementsAre(1.0, 2.0));
  const auto second = ReadWhole(path, 1);
  EXPECT_EQ(second.info.scan_index, 1);
  EXPECT_EQ(second.info.point_count, 0U);
  EXPECT_EQ(second.chunks, 0U);
  EXPECT_EQ(ReadWhole(path, 2).points.size(), 2000U);
  EXPECT_THAT(ReadError(path, 3), HasSubstr("scan_index from 0 to 2"));
  EXPECT_THAT(ReadError(path, -1), HasSubstr("scan_index from 0 to 2"));
}

TEST(E57Reader, BytestreamsNeedNotKeepPace) {
  // x comes in the first packets, y and z in the last ones, each value torn apart.
  constexpr std::size_t kRecords = 150'000;
  std::vector<float> values(kRecords);
  for (std::size_t i = 0; i < kRecords; ++i) values[i] = static_cast<float>(i);
  const std::string stream = PackNumbers(values);
  TestScan scan{"", kXyzSingle, kRecords, {}};
  for (const std::size_t field : {0U, 1U, 2U}) {
    for (std::size_t at = 0; at < stream.size(); at += 65001) {
      std::vector<std::string> streams(3);
      streams[field] = stream.substr(at, 65001);
      scan.packets.push_back(DataPacket(streams));
      scan.packets.push_back(std::string("\x02\0\x07\0PADS", 8));  // a packet to be ignored
    }
  }
  const auto whole = Read(scan);
  EXPECT_EQ(whole.chunks, 10U);
  ASSERT_EQ(whole.points.size(), kRecords);
  for (std::size_t i = 0; i < kRecords; i += 777) {
    EXPECT_EQ(whole.points.x[i], static_cast<double>(i));
    EXPECT_EQ(whole.points.z[i], static_cast<double>(i));
  }
}

TEST(E57Reader, PassesOverExtensions) {
  TestScan scan = XyzScan({1, 2});
  scan.prototype =
      "<nor:normal type='Structure'><nor:x type='Float'/><cartesianX type='Integer' minimum='0' "
      "maximum='3'/></nor:normal><nor:label type='String'/>" +
      scan.prototype;
  auto streams = Xyz({1, 2});
  streams.insert(streams.begin(), {PackNumbers<double>({9, 9}), "\x01", std::string("\2a\0", 3)});
  scan.packets = {DataPacket(streams)};
  EXPECT_THAT(Read(scan).points.x, ElementsAre(1.0, 2.0));
}

TEST(E57Reader, ARestartDropsTheBitsThatFillUpAByte) {
  std::string prototype;
  for (const std::string name : {"X", "Y", "Z"}) {
    prototype += "<cartesian" + name + " type='Integer' minimum='1' maximum='7'/>";
  }
  const std::string one = PackBits(std::vector<std::uint64_t>{1, 2}, 3);
  const std::string two = PackBits(std::vector<std::uint64_t>{5}, 3);
  const auto scan =
      Read({"", prototype, 3, {DataPacket({one, one, one}, 1), DataPacket({two, two, two}, 1)}});
  EXPECT_THAT(scan.points.y, ElementsAre(2.0, 3.0, 6.0));
}

TEST(E57Reader, NamesWhatIsWrong) {
  const std::string values = PackNumbers<double>({1, 2});
  const auto with = [&](const std::string& prototype, std::uint64_t records = 2) {
    return ErrorIn({"", prototype, records, {DataPacket({values, values, values})}});
  };
  EXPECT_THAT(with("<cartesianX type='Float'/>"), HasSubstr("lacks a coordinate"));
  EXPECT_THAT(with(std::string(kXyzDouble) + "<rowIndex type='Integer'/>"),
              HasSubstr("a packet of 3 bytestreams; expected 4"));
  EXPECT_THAT(with(kXyzDouble, 3), HasSubstr("only 2 values of field 'cartesianX'"));
  EXPECT_THAT(with(kXyzDouble, 1'000'000'000'000), HasSubstr("1000000000000 records; expected at"));
  EXPECT_THAT(with("<cartesianX type='Integer' minimum='3' maximum='2'/>"), HasSubstr("minimum 3"));
  EXPECT_THAT(with("<cartesianX type='Integer' minimum='0.5'/>"), HasSubstr("minimum '0.5'"));
  EXPECT_THAT(with("<cartesianX type='ScaledInteger' scale='nan'/>"), HasSubstr("scale 'nan'"));
  EXPECT_THAT(with("<cartesianX type='ScaledInteger' scale='0'/>"), HasSubstr("scale 0"));
  EXPECT_THAT(with("<cartesianX type='Float' precision='half'/>"), HasSubstr("precision 'half'"));
  EXPECT_THAT(with("<cartesianX type='Blob'/>"), HasSubstr("type 'Blob'"));
  EXPECT_THAT(with(""), HasSubstr("no fields"));
  std::string bitless;
  for (const std::string name : {"X", "Y", "Z"}) {
    bitless += "<cartesian" + name + " type='Integer' minimum='1' maximum='1'/>";
  }
  EXPECT_THAT(with(bitless, UINT64_MAX / 2), HasSubstr("expected at most 65536 records"));
  const std::string wide = "<cartesianX type='Integer' minimum='1' maximum='6'/>" +
                           bitless.substr(bitless.find("<cartesianY"));
  EXPECT_THAT(ErrorIn({"", wide, 2, {DataPacket({"\x38", "", ""})}}),
              HasSubstr("7 above its minimum; expected 1 to 6"));
}

}  // namespace
}  // namespace backsight
