#include <gmock/gmock.h>

#include <string>

#include "io/e57/page_layout.h"
#include "io/utf8.h"
#include "tests/io/e57/e57_bytes.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Reads every scan of the file; true if all of them end well. Anything but an InputError that
/// names the file fails the test.
bool IsReadable(const TempDir& dir, const std::string& bytes) {
  const std::string path = dir.File("damaged.e57", bytes);
  try {
    const int scans = OpenScan(path)->info().scan_count;
    for (int i = 0; i < std::min(scans, 3); ++i) {
      const auto scan = ReadWhole(path, i);
      for (const auto* axis : {&scan.points.x, &scan.points.y, &scan.points.z}) {
        for (const double value : *axis) EXPECT_TRUE(std::isfinite(value));
      }
      for (const float value : scan.points.intensity) EXPECT_TRUE(value >= 0.0F && value <= 1.0F);
    }
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("damaged.e57"));
    return false;
  }
  return true;
}

TEST(E57Damage, ACutFileIsRefusedWhereverItIsCut) {
  const TempDir dir;
  const std::string whole = Paged(RichE57Payload());
  ASSERT_TRUE(IsReadable(dir, whole));
  for (std::size_t n = 1; n < whole.size(); n += 1 + whole.size() / 300) {
    EXPECT_FALSE(IsReadable(dir, whole.substr(0, n))) << n;
  }
  EXPECT_THAT(ReadError(dir.File("a.e57", whole.substr(0, 2048))),
              HasSubstr("byte 2048: only 2048 bytes are available"));
}

TEST(E57Damage, AnyFlippedBitIsFoundByThePageChecksum) {
  const TempDir dir;
  const std::string whole = Paged(RichE57Payload());
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 200) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_FALSE(IsReadable(dir, damaged)) << at;
  }
  std::string damaged = whole;
  damaged[kE57PageBytes + 500] = static_cast<char>(damaged[kE57PageBytes + 500] ^ 1);
  EXPECT_THAT(ReadError(dir.File("a.e57", damaged)),
              AllOf(HasSubstr("a.e57: byte 1024: page 1 with checksum"), HasSubstr("export it")));
}

TEST(E57Damage, MessagesQuoteNoRawBytesOfTheFile) {
  const TempDir dir;
  const auto error = [&](const std::string& prototype) {
    return ReadError(dir.File("a.e57", Paged(E57Payload({{"", prototype, 0, {}}}))));
  };
  for (const std::string& message : {error("<b\xff\xe9 type='Nope'/>"),
                                     error("<b\xff\xe9 type='Integer' minimum='9' maximum='2'/>"),
                                     error("<rowIndex type='Integer' minimum='\xff'/>")}) {
    EXPECT_EQ(message, CleanUtf8(message));
    EXPECT_THAT(message, HasSubstr("\\xff"));
  }
}

TEST(E57Damage, WhateverThePagesHoldIsReadOrRefused) {
  const TempDir dir;
  const std::string payload = RichE57Payload();
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Random random(seed);
    std::string damaged = payload;
    for (std::uint64_t hits = 1 + random.Index(4); hits > 0; --hits) {
      // Half of the hits go to the header and the first section's head, where they hurt most.
      const std::size_t at = random.Index(random.Index(2) == 0 ? 120 : damaged.size());
      damaged[at] = static_cast<char>(random.Index(3) == 0 ? damaged[at] ^ (1 << random.Index(8))
                                                           : static_cast<int>(random.Index(256)));
    }
    if (!IsReadable(dir, Paged(damaged))) ++refused;
  }
  EXPECT_GT(refused, 700);
}

/// The message for a file of one section whose XML is `elements` within e57Root.
std::string XmlError(const std::string& elements) {
  const TempDir dir;
  const std::string values = PackNumbers<double>({1, 2});
  const std::string payload =
      E57PayloadOf({DataPacket({values, values, values})}, RootXml(elements));
  return ReadError(dir.File("a.e57", Paged(payload)));
}

std::string ScanXml(const std::string& points, const std::string& before = "") {
  return "<data3D type='Vector'><vectorChild type='Structure'>" + before + points +
         "</vectorChild></data3D>";
}

std::string PointsXml(const std::string& attributes, const std::string& more = "") {
  return "<points type='CompressedVector' " + attributes +
         "><prototype type='Structure'><cartesianX type='Float'/><cartesianY type='Float'/>"
         "<cartesianZ type='Float'/>" +
         more + "</prototype></points>";
}

TEST(E57Damage, HostileXmlIsRefused) {
  const auto points_error = [](const std::string& attributes, const std::string& more = "") {
    return XmlError(ScanXml(PointsXml(attributes, more)));
  };
  EXPECT_THAT(XmlError(""), HasSubstr("no element 'data3D'"));
  EXPECT_THAT(XmlError("<data3D/>"), HasSubstr("expected a file with scans"));
  EXPECT_THAT(XmlError("<data3D><vectorChild/></data3D>"), HasSubstr("no element 'points'"));
  EXPECT_THAT(XmlError("<data3D>"), HasSubstr("damaged XML"));
  EXPECT_THAT(XmlError(ScanXml("<points type='Blob'/>")), HasSubstr("type 'Blob'"));
  EXPECT_THAT(points_error(""), HasSubstr("fileOffset ''"));
  EXPECT_THAT(points_error("fileOffset='@' recordCount='-1'"), HasSubstr("recordCount '-1'"));
  EXPECT_THAT(points_error("fileOffset='@' recordCount='9223372036854775807'"),
              HasSubstr("9223372036854775807 records; expected at most"));
  EXPECT_THAT(points_error("fileOffset='@' recordCount='9223372036854775808'"),
              HasSubstr("recordCount '9223372036854775808'"));
  for (const std::string offset : {"1020", "1023", "999999", "9223372036854775807"}) {
    EXPECT_THAT(points_error("fileOffset='" + offset + "' recordCount='2'"),
                HasSubstr("a section of points at byte " + offset));
  }
  EXPECT_THAT(points_error("fileOffset='0' recordCount='2'"), HasSubstr("a section of kind 65"));
  EXPECT_THAT(points_error("fileOffset='@' recordCount='2'", "<a type='Float'/>"),
              HasSubstr("3 bytestreams; expected 4"));
  EXPECT_THAT(XmlError(ScanXml(PointsXml("fileOffset='@' recordCount='2'"),
                               "<pose><translation><x>inf</x></translation></pose>")),
              HasSubstr("'inf'"));
  EXPECT_THAT(XmlError(ScanXml(PointsXml("fileOffset='@' recordCount='2'"),
                               "<intensityLimits><intensityMinimum>a</intensityMinimum>"
                               "<intensityMaximum/></intensityLimits>")),
              HasSubstr("in XML element 'intensityMinimum': 'a'"));
  EXPECT_THAT(XmlError(ScanXml("<points type='CompressedVector' fileOffset='@' recordCount='2'>"
                               "<prototype/><codecs><vectorChild><zip/></vectorChild></codecs>"
                               "</points>")),
              HasSubstr("no fields"));
}

TEST(E57Damage, DeepAndWideXmlIsRefusedWithoutRecursion) {
  std::string deep;
  std::string wide;
  for (int i = 0; i < 200'000; ++i) deep += "<s type='Structure'>";
  for (int i = 0; i < 33'000; ++i) wide += "<f type='Float'/>";
  std::string close;
  for (int i = 0; i < 200'000; ++i) close += "</s>";
  const std::string place = "fileOffset='@' recordCount='2'";
  EXPECT_THAT(XmlError(ScanXml(PointsXml(place, deep))), HasSubstr("damaged XML"));
  EXPECT_THAT(XmlError(ScanXml(PointsXml(place, deep + "<f type='Float'/>" + close))),
              HasSubstr("3 bytestreams; expected 4"));
  EXPECT_THAT(XmlError(ScanXml(PointsXml(place, wide))), HasSubstr("at most 32000 fields"));
  EXPECT_THAT(XmlError("<!DOCTYPE e57Root [<!ENTITY a \"aaaa\">]><data3D/>"), HasSubstr("a.e57"));
}

TEST(E57Damage, HostileFileHeadersAreRefused) {
  const TempDir dir;
  const auto error = [&](std::size_t at, std::uint64_t value) {
    std::string payload = RichE57Payload();
    StoreBytes(&payload[at], value);
    return ReadError(dir.File("a.e57", Paged(payload)));
  };
  EXPECT_THAT(error(8, 2), HasSubstr("byte 8: format version 2"));
  EXPECT_THAT(error(16, UINT64_MAX), HasSubstr("are available"));
  EXPECT_THAT(error(16, 0), HasSubstr("a file length of 0 bytes"));
  EXPECT_THAT(error(16, 1025), HasSubstr("a multiple of 1024"));
  EXPECT_THAT(error(24, UINT64_MAX), HasSubstr("the XML section at byte 18446744073709551615"));
  EXPECT_THAT(error(24, 1021), HasSubstr("that is no checksum"));
  EXPECT_THAT(error(32, UINT64_MAX), HasSubstr("an XML section of 18446744073709551615 bytes"));
  EXPECT_THAT(error(32, 0), HasSubstr("an XML section of 0 bytes"));
  EXPECT_THAT(error(40, 0), HasSubstr("pages of 0 bytes"));
}

TEST(E57Damage, BytesBehindTheEndAreNoted) {
  const TempDir dir;
  const auto scan = ReadWhole(dir.File("a.e57", Paged(RichE57Payload()) + "tail"));
  EXPECT_EQ(scan.tally.records, 168U);
  EXPECT_THAT(scan.info.notes.at(0), HasSubstr("4 bytes behind the end"));
}

}  // namespace
}  // namespace backsight
