#include "io/e57/e57_writer.h"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/io/e57/e57_bytes.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Cloud {
  PointChunk points;
  std::vector<std::uint8_t> states;
};

Cloud RandomCloud(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    cloud.points.x.push_back(random.Uniform(-50.0, 50.0));
    cloud.points.y.push_back(random.Uniform(-50.0, 50.0));
    cloud.points.z.push_back(random.Uniform(-50.0, 50.0));
    cloud.points.intensity.push_back(static_cast<float>(random.Uniform()));
    const auto color = [&random] { return static_cast<std::uint16_t>(random.Index(65536)); };
    cloud.points.rgb.push_back({color(), color(), color()});
    cloud.points.row.push_back(static_cast<std::int32_t>(random.Index(1000)));
    cloud.points.column.push_back(static_cast<std::int32_t>(random.Index(77)));
    cloud.states.push_back(static_cast<std::uint8_t>(random.Index(10) == 0 ? 1 + i % 2 : 0));
  }
  return cloud;
}

E57FileSpec File(const std::string& path) {
  return {path, "{FILE}", "backsight 0.1.0", "ENGCRS[]", 1234567890.5};
}

void WriteScan(const std::string& path, const E57ScanSpec& scan, const Cloud& cloud) {
  E57Writer writer(File(path));
  writer.BeginScan(scan);
  writer.Write(cloud.points, cloud.states);
  EXPECT_EQ(writer.EndScan(), cloud.points.size());
  writer.Finish();
}

/// What a reader should give of the coordinate `value`.
double Stored(double value, E57Coordinates coordinates, double scale_m) {
  switch (coordinates) {
    case E57Coordinates::kSingle:
      return static_cast<double>(static_cast<float>(value));
    case E57Coordinates::kScaledInteger:
      return std::round(value / scale_m) * scale_m;
    case E57Coordinates::kDouble:
      break;
  }
  return value;
}

TEST(E57Writer, EveryCombinationIsReadBackExactly) {
  const TempDir dir;
  const std::string path = dir / "a.e57";
  for (unsigned choice = 0; choice < 48; ++choice) {
    Random random(choice);
    E57ScanSpec spec;
    spec.coordinates = static_cast<E57Coordinates>(choice % 3);
    spec.scale_m = random.Uniform(1e-5, 1e-2);
    spec.min.setConstant(-50.0);
    spec.max.setConstant(50.0);
    spec.has_invalid_state = (choice & 1U) != 0;
    spec.has_intensity = (choice & 2U) != 0;
    spec.has_rgb = (choice & 4U) != 0;
    spec.rgb_16_bit = (choice & 8U) != 0;
    if ((choice & 16U) != 0) spec.rows = 1000, spec.columns = 77;
    const Cloud cloud = RandomCloud(random.Index(6000), choice);
    WriteScan(path, spec, cloud);
    const auto scan = ReadWhole(path);
    EXPECT_EQ(scan.tally.records, cloud.points.size());
    EXPECT_EQ(scan.info.rows, spec.rows);
    EXPECT_EQ(scan.info.columns, spec.columns);
    EXPECT_EQ(scan.info.rgb_16_bit, spec.has_rgb && spec.rgb_16_bit);
    std::size_t at = 0;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (spec.has_invalid_state && cloud.states[i] != 0) continue;
      ASSERT_LT(at, scan.points.size());
      ASSERT_EQ(scan.points.x[at], Stored(cloud.points.x[i], spec.coordinates, spec.scale_m));
      ASSERT_EQ(scan.points.z[at], Stored(cloud.points.z[i], spec.coordinates, spec.scale_m));
      if (spec.has_intensity) {
        ASSERT_EQ(scan.points.intensity[at], cloud.points.intensity[i]);
      }
      if (spec.rows > 0) {
        ASSERT_EQ(scan.points.row[at], cloud.points.row[i]);
        ASSERT_EQ(scan.points.column[at], cloud.points.column[i]);
      }
      for (std::size_t c = 0; c < 3 && spec.has_rgb; ++c) {
        const int color = cloud.points.rgb[i][c];
        ASSERT_EQ(scan.points.rgb[at][c], spec.rgb_16_bit ? color : (color + 128) / 257 * 257);
      }
      ++at;
    }
    EXPECT_EQ(at, scan.points.size());
  }
}

TEST(E57Writer, SeveralScansKeepNamesGuidsAndPoses) {
  const TempDir dir;
  const std::string path = dir / "a.e57";
  Random random(7);
  const std::vector<std::size_t> sizes{1, 0, 200'000, 17};
  std::vector<RigidTransform> poses;
  std::vector<Cloud> clouds;
  E57Writer writer(File(path));
  for (const std::size_t n : sizes) {
    poses.push_back({random.Rotation(), {691000.123456789, -2.5, random.Normal()}});
    clouds.push_back(RandomCloud(n, n));
    E57ScanSpec spec;
    spec.guid = "{SCAN-" + std::to_string(n) + "}";
    spec.name = "B\xc3\xbcro <" + std::to_string(n) + "> ]]> & \x01\xff";
    spec.world_from_scan = poses.back();
    writer.BeginScan(spec);
    writer.Write(clouds.back().points);
    writer.EndScan();
  }
  writer.Finish();
  EXPECT_EQ(dir.FileCount(), 1U);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const auto scan = ReadWhole(path, static_cast<int>(i));
    const std::string n = std::to_string(sizes[i]);
    EXPECT_EQ(scan.info.scan_count, 4);
    EXPECT_EQ(scan.info.guid, "{SCAN-" + n + "}");
    EXPECT_EQ(scan.info.crs, "ENGCRS[]");
    EXPECT_EQ(scan.info.name, "B\xc3\xbcro <" + n + "> ]]> & ??");
    EXPECT_EQ(scan.points.x, clouds[i].points.x);
    EXPECT_EQ(scan.points.y, clouds[i].points.y);
    EXPECT_TRUE(scan.info.notes.empty());
    EXPECT_EQ(scan.info.world_from_scan->translation, poses[i].translation);
    EXPECT_LT((scan.info.world_from_scan->rotation - poses[i].rotation).norm(), 1e-14);
  }
}

TEST(E57Writer, EqualCallsGiveEqualBytes) {
  const TempDir dir;
  const Cloud cloud = RandomCloud(5000, 1);
  E57ScanSpec spec;
  spec.has_intensity = true;
  WriteScan(dir / "a.e57", spec, cloud);
  WriteScan(dir / "b.e57", spec, cloud);
  const std::string bytes = ReadBytes(dir / "a.e57");
  EXPECT_EQ(bytes, ReadBytes(dir / "b.e57"));
  EXPECT_EQ(bytes, Paged(Payload(bytes)));  // all checksums are right
}

TEST(E57Writer, XmlHasTheElementsOfTheStandardInTheirOrder) {
  const TempDir dir;
  E57ScanSpec spec;
  spec.guid = "{SCAN}";
  spec.has_rgb = true;
  spec.rows = 3;
  spec.columns = 5;
  Cloud cloud = RandomCloud(1, 2);
  cloud.points.x = {1.5};
  cloud.points.row = {2};
  cloud.points.column = {4};
  WriteScan(dir / "a.e57", spec, cloud);
  const std::string payload = Payload(ReadBytes(dir / "a.e57"));
  std::size_t at = 0;
  for (const char* element :
       {"<e57Root type=\"Structure\" xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">",
        "<formatName type=\"String\"><![CDATA[ASTM E57 3D Imaging Data File]]></formatName>",
        "<guid type=\"String\"><![CDATA[{FILE}]]></guid>",
        "<versionMajor type=\"Integer\">1</versionMajor>",
        "<versionMinor type=\"Integer\">0</versionMinor>",
        "<e57LibraryVersion type=\"String\"><![CDATA[backsight 0.1.0]]>",
        "<coordinateMetadata type=\"String\"><![CDATA[ENGCRS[]]]>",
        "<creationDateTime type=\"Structure\">",
        "<dateTimeValue type=\"Float\">1234567890.5<",
        "<isAtomicClockReferenced type=\"Integer\">0",
        "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">",
        "<vectorChild type=\"Structure\">",
        "<![CDATA[{SCAN}]]>",
        "<rowMaximum type=\"Integer\">2<",
        "<columnMaximum type=\"Integer\">4<",
        "<colorBlueMaximum type=\"Integer\">255<",
        "<xMinimum type=\"Float\">1.5<",
        "<xMaximum type=\"Float\">1.5<",
        "<pose type=\"Structure\">",
        "<points type=\"CompressedVector\" fileOffset=\"48\" recordCount=\"1\">",
        "<cartesianX type=\"Float\" precision=\"double\"/>",
        "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"2\"/>",
        "<colorRed type=\"Integer\" minimum=\"0\" maximum=\"255\"/>",
        "<codecs type=\"Vector\"",
        "<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\">",
        "</e57Root>"}) {
    const std::size_t next = payload.find(element, at);
    ASSERT_NE(next, std::string::npos) << element;
    at = next;
  }
}

TEST(E57Writer, RefusesWhatItCannotHold) {
  const TempDir dir;
  const std::string path = dir / "a.e57";
  const auto error = [&](const E57ScanSpec& spec, double x) {
    return ErrorOf([&] {
      Cloud cloud = RandomCloud(1, 1);
      cloud.points.x = {x};
      WriteScan(path, spec, cloud);
    });
  };
  E57ScanSpec spec;
  EXPECT_THAT(error(spec, NAN), HasSubstr("a point with cartesianX nan m"));
  spec.coordinates = E57Coordinates::kSingle;
  EXPECT_THAT(error(spec, 1e300), HasSubstr("write double coordinates"));
  spec.coordinates = E57Coordinates::kScaledInteger;
  spec.min.setConstant(-50.0);
  spec.max.setConstant(50.0);
  EXPECT_THAT(error(spec, 51.0), HasSubstr("a point with cartesianX 51 m; expected -50 to 50 m"));
  spec.scale_m = 1e-15;
  EXPECT_THAT(error(spec, 1.0), HasSubstr("choose a coarser step"));
  EXPECT_EQ(dir.FileCount(), 0U);
  EXPECT_THAT(ErrorOf([&] { E57Writer writer(File(dir / "no/such/a.e57")); }),
              HasSubstr("create the directory first"));
}

TEST(E57Writer, RecordsMarkedAsInvalidMayHoldAnything) {
  const TempDir dir;
  E57ScanSpec spec;
  spec.coordinates = E57Coordinates::kScaledInteger;
  spec.max.setConstant(1.0);
  spec.has_invalid_state = true;
  Cloud cloud = RandomCloud(2, 1);
  cloud.points.x = {NAN, 0.5};
  cloud.points.y = {1e9, 0.5};
  cloud.points.z = {0.5, 0.5};
  cloud.states = {2, 0};
  WriteScan(dir / "a.e57", spec, cloud);
  const auto scan = ReadWhole(dir / "a.e57");
  EXPECT_EQ(scan.tally.no_return, 1U);
  EXPECT_THAT(scan.points.x, ElementsAre(0.5));
}

TEST(E57Writer, OffsetsReachBeyondFourGigabytes) {
  // The pages between header and section are a hole in the file that no reader looks at.
  const TempDir dir;
  constexpr std::uint64_t kGapPages = 5'000'000;
  const Cloud cloud = RandomCloud(100, 1);
  WriteScan(dir / "a.e57", {}, cloud);
  std::string payload = Payload(ReadBytes(dir / "a.e57"));
  const std::uint64_t shift = kGapPages * kE57PageBytes;
  const auto add = [&](std::size_t at, std::uint64_t more) {
    StoreBytes(&payload[at], LoadBytes<std::uint64_t>(&payload[at]) + more);
  };
  const std::string stated = "fileOffset=\"48\"";
  const std::string moved = "fileOffset=\"" + std::to_string(48 + shift) + "\"";
  payload.replace(payload.find(stated), stated.size(), moved);
  const std::size_t xml_offset = 24;
  const std::size_t xml_bytes = 32;
  const std::size_t first_packet = kE57HeaderBytes + 16;
  add(xml_offset, shift);
  add(xml_bytes, moved.size() - stated.size());
  add(first_packet, shift);
  StoreBytes(&payload[16], shift + Paged(payload).size());
  const std::string path = dir.File("far.e57", Paged(payload.substr(0, kE57PayloadBytes)));
  std::ofstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(shift));
  const std::string pages = Paged(payload);
  file.write(pages.data(), static_cast<std::streamsize>(pages.size()));
  file.close();
  const auto scan = ReadWhole(path);
  EXPECT_EQ(scan.points.x, cloud.points.x);
}

}  // namespace
}  // namespace backsight
