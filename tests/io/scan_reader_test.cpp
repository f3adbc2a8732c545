#include "io/scan_reader.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kPtx =
    "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n";
constexpr const char* kPcd =
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n1 2 3\n";

TEST(OpenScan, ContentGoesBeforeExtension) {
  const TempDir dir;
  for (const std::string name : {"a", "a.xyz", "a.ply", "a.pcd", "a.PTX", "a.las", "a.dat"}) {
    EXPECT_EQ(ReadWhole(dir.File(name, kPtx)).info.format, "PTX") << name;
    EXPECT_EQ(ReadWhole(dir.File(name, kPcd)).info.format, "PCD") << name;
    EXPECT_EQ(ReadWhole(dir.File(name, kPly)).info.format, "PLY") << name;
  }
  EXPECT_EQ(ReadWhole(dir.File("cloud.dat", "1 2 3\n")).info.format, "XYZ");
  EXPECT_EQ(ReadWhole(dir.File("cloud.pts", "1\n1 2 3\n")).info.format, "PTS");
  EXPECT_EQ(ReadWhole(dir.File("cloud.xyz", "1\n1 2 3\n")).info.format, "PTS");
}

TEST(OpenScan, NamesFormatsItCannotRead) {
  const TempDir dir;
  std::string las = "LASF" + std::string(500, '\0');
  EXPECT_THAT(ReadError(dir.File("a.las", las)), HasSubstr("LAS version 0.0"));
  for (const char packed : {'\x83', '\x43'}) {
    las[104] = packed;
    EXPECT_THAT(ReadError(dir.File("a.laz", las)),
                AllOf(HasSubstr("LAZ file"), HasSubstr("E57, LAS, PCD, PLY, PTX"),
                      HasSubstr("laszip"), HasSubstr("pdal translate"), HasSubstr("CloudCompare")));
  }
  las.replace(377, 4, "copc");
  EXPECT_THAT(ReadError(dir.File("a.laz", las)), HasSubstr("COPC file"));
  EXPECT_THAT(ReadError(dir.File("a.txt", "ASTM-E57" + std::string(40, '\0'))),
              HasSubstr("only 48 bytes of a page are available"));
  EXPECT_THAT(ReadError(dir.File("a.e57", "something else")), HasSubstr("named .e57"));
  EXPECT_THAT(ReadError(dir.File("a.zip", "PK\x03\x04 and so on")), HasSubstr("unpack"));
  EXPECT_THAT(ReadError(dir.File("a.doc", "Dear reader,\n")),
              AllOf(HasSubstr("unknown format"), HasSubstr("Dear reader")));
}

TEST(OpenScan, NamesWhatIsNoFile) {
  const TempDir dir;
  EXPECT_THAT(ReadError(dir / "missing.ptx"), HasSubstr("No such file"));
  EXPECT_THAT(ReadError(dir.path()), HasSubstr("is a directory"));
  EXPECT_THAT(ReadError(dir.File("empty.ply", "")), HasSubstr("is empty"));
  ASSERT_EQ(::mkfifo((dir / "pipe.ptx").c_str(), 0600), 0);
  EXPECT_THAT(ReadError(dir / "pipe.ptx"), HasSubstr("not a regular file"));
}

TEST(OpenScan, OneScanFilesHaveOnlyIndexZero) {
  const TempDir dir;
  EXPECT_THAT(ReadError(dir.File("a.pcd", kPcd), 1), HasSubstr("no scan with index 1"));
  EXPECT_THAT(ReadError(dir.File("a.ply", kPly), -1), HasSubstr("no scan with index -1"));
}

}  // namespace
}  // namespace backsight
