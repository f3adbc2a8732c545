#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "io/cloud_writer.h"
#include "io/las_check.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// A reader of its own, straight from the tables of the LAS 1.4 R15 specification.
class LasBytes {
 public:
  explicit LasBytes(std::string bytes) : bytes_(std::move(bytes)) {}

  std::uint64_t Unsigned(std::size_t at, std::size_t n) const {
    std::uint64_t value = 0;
    for (std::size_t i = n; i-- > 0;) {
      value = value << 8U | static_cast<unsigned char>(bytes_.at(at + i));
    }
    return value;
  }
  std::int32_t Signed32(std::size_t at) const {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(Unsigned(at, 4)));
  }
  double Real(std::size_t at) const { return std::bit_cast<double>(Unsigned(at, 8)); }
  std::string Text(std::size_t at, std::size_t n) const {
    return std::string(bytes_.substr(at, n).c_str());
  }
  std::size_t size() const { return bytes_.size(); }
  Eigen::Vector3d Point(std::size_t i) const {
    const std::size_t at = Unsigned(96, 4) + i * Unsigned(105, 2);
    Eigen::Vector3d p;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      p[a] = Signed32(at + 4 * axis) * Real(131 + 8 * axis) + Real(155 + 8 * axis);
    }
    return p;
  }

 private:
  std::string bytes_;
};

CloudWriterSpec Spec(const std::string& path, bool rgb) {
  CloudWriterSpec spec;
  spec.path = path;
  spec.has_intensity = true;
  spec.has_rgb = rgb;
  spec.min = {691000.0, 5335000.0, 400.0};
  spec.max = {691500.0, 5335700.0, 600.0};
  spec.generator = "backsight 0.1.0";
  return spec;
}

PointChunk RandomChunk(const CloudWriterSpec& spec, std::size_t n, std::uint64_t seed) {
  Random random(seed);
  PointChunk chunk;
  for (std::size_t i = 0; i < n; ++i) {
    chunk.x.push_back(random.Uniform(spec.min.x(), spec.max.x()));
    chunk.y.push_back(random.Uniform(spec.min.y(), spec.max.y()));
    chunk.z.push_back(random.Uniform(spec.min.z(), spec.max.z()));
    chunk.intensity.push_back(static_cast<float>(random.Uniform()));
    if (!spec.has_rgb) continue;
    chunk.rgb.push_back({static_cast<std::uint16_t>(random.Index(65536)), 7, 65535});
  }
  return chunk;
}

void ExpectFixedHeader(const LasBytes& las, bool rgb) {
  EXPECT_EQ(las.Text(0, 4), "LASF");
  EXPECT_EQ(las.Unsigned(4, 2), 0U);     // file source ID
  EXPECT_EQ(las.Unsigned(6, 2), 0x10U);  // global encoding: WKT, GPS week time
  EXPECT_EQ(las.Unsigned(8, 8), 0U);     // project ID
  EXPECT_EQ(las.Unsigned(16, 8), 0U);
  EXPECT_EQ(las.Unsigned(24, 1), 1U);
  EXPECT_EQ(las.Unsigned(25, 1), 4U);
  EXPECT_EQ(las.Text(26, 32), "MERGE");
  EXPECT_EQ(las.Text(58, 32), "backsight 0.1.0");
  EXPECT_EQ(las.Unsigned(90, 4), 0U);  // creation day and year
  EXPECT_EQ(las.Unsigned(94, 2), 375U);
  EXPECT_EQ(las.Unsigned(96, 4), 375U);
  EXPECT_EQ(las.Unsigned(100, 4), 0U);  // VLRs
  EXPECT_EQ(las.Unsigned(104, 1), rgb ? 7U : 6U);
  EXPECT_EQ(las.Unsigned(105, 2), rgb ? 36U : 30U);
  for (std::size_t at = 107; at < 131; at += 4) EXPECT_EQ(las.Unsigned(at, 4), 0U);  // legacy
  EXPECT_EQ(las.Unsigned(227, 8), 0U);  // waveform data
  EXPECT_EQ(las.Unsigned(235, 8), 0U);  // EVLRs
  EXPECT_EQ(las.Unsigned(243, 4), 0U);
}

class LasWriter : public ::testing::TestWithParam<bool> {};

TEST_P(LasWriter, FollowsTheSpecificationByteByByte) {
  const TempDir dir;
  const auto spec = Spec(dir / "a.las", GetParam());
  const PointChunk first = RandomChunk(spec, 1000, 1);
  const PointChunk second = RandomChunk(spec, 70000, 2);
  const auto writer = CreateLasWriter(spec);
  writer->Write(first, 1);
  writer->Write(second, 65535);
  EXPECT_EQ(writer->Finish(), 71000U);

  const LasBytes las(ReadBytes(spec.path));
  ExpectFixedHeader(las, GetParam());
  EXPECT_EQ(las.Unsigned(247, 8), 71000U);
  EXPECT_EQ(las.Unsigned(255, 8), 71000U);  // first returns
  for (std::size_t at = 263; at < 375; at += 8) EXPECT_EQ(las.Unsigned(at, 8), 0U);
  const std::size_t record = GetParam() ? 36 : 30;
  ASSERT_EQ(las.size(), 375 + 71000 * record);

  Eigen::Vector3d min = Eigen::Vector3d::Constant(1e30);
  Eigen::Vector3d max = -min;
  for (std::size_t i = 0; i < 71000; ++i) {
    const bool early = i < 1000;
    const PointChunk& chunk = early ? first : second;
    const std::size_t k = early ? i : i - 1000;
    const std::size_t at = 375 + i * record;
    const Eigen::Vector3d point = las.Point(i);
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
    const Eigen::Vector3d truth(chunk.x[k], chunk.y[k], chunk.z[k]);
    ASSERT_LE((point - truth).cwiseAbs().maxCoeff(), 0.5001e-4);
    ASSERT_EQ(las.Unsigned(at + 12, 2),
              static_cast<std::uint64_t>(std::lround(chunk.intensity[k] * 65535.0F)));
    ASSERT_EQ(las.Unsigned(at + 14, 1), 0x11U);  // return 1 of 1
    ASSERT_EQ(las.Unsigned(at + 15, 1), 0U);     // flags
    ASSERT_EQ(las.Unsigned(at + 16, 4), 0U);     // class, user data, scan angle
    ASSERT_EQ(las.Unsigned(at + 20, 2), early ? 1U : 65535U);
    ASSERT_EQ(las.Unsigned(at + 22, 8), 0U);  // GPS time
    for (std::size_t c = 0; c < 3 && GetParam(); ++c) {
      ASSERT_EQ(las.Unsigned(at + 30 + 2 * c, 2), chunk.rgb[k][c]);
    }
  }
  for (int a = 0; a < 3; ++a) {
    EXPECT_EQ(las.Real(179 + 16 * static_cast<std::size_t>(a)), max[a]);
    EXPECT_EQ(las.Real(187 + 16 * static_cast<std::size_t>(a)), min[a]);
  }
  EXPECT_EQ(VerifyLas(spec.path).points, 71000U);
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST_P(LasWriter, GivesTheSameBytesEachTime) {
  const TempDir dir;
  std::array<std::string, 2> bytes;
  for (std::string& run : bytes) {
    const auto spec = Spec(dir / "a.las", GetParam());
    const auto writer = CreateLasWriter(spec);
    writer->Write(RandomChunk(spec, 100, 3), 5);
    writer->Finish();
    run = ReadBytes(spec.path);
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

INSTANTIATE_TEST_SUITE_P(Colors, LasWriter, ::testing::Bool());

TEST(LasWriterLimits, WritesAnEmptyCloud) {
  const TempDir dir;
  EXPECT_EQ(CreateLasWriter(Spec(dir / "a.las", false))->Finish(), 0U);
  EXPECT_EQ(VerifyLas(dir / "a.las").points, 0U);
}

TEST(LasWriterLimits, MissingAttributesBecomeZero) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", true);
  PointChunk chunk = RandomChunk(spec, 1, 4);
  chunk.intensity.clear();
  chunk.rgb.clear();
  const auto writer = CreateLasWriter(spec);
  writer->Write(chunk, 1);
  writer->Finish();
  const LasBytes las(ReadBytes(spec.path));
  EXPECT_EQ(las.Unsigned(375 + 12, 2), 0U);
  EXPECT_EQ(las.Unsigned(375 + 30, 6), 0U);
}

TEST(LasWriterLimits, FillsTheWholeIntegerRange) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  spec.scale_m = 1e-4;
  spec.min = {0.3, -214748.3, 0.0};
  spec.max = {429496.5, 214748.3, 0.0};
  const auto writer = CreateLasWriter(spec);
  PointChunk chunk;
  chunk.x = {spec.min.x(), spec.max.x()};
  chunk.y = {spec.min.y(), spec.max.y()};
  chunk.z = {0.0, 0.0};
  writer->Write(chunk, 1);
  writer->Finish();
  const LasBytes las(ReadBytes(spec.path));
  EXPECT_NEAR(las.Point(0).x(), 0.3, 1e-4);
  EXPECT_NEAR(las.Point(1).x(), 429496.5, 1e-4);
}

TEST(LasWriterLimits, RefusesWhatLasCannotHold) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  spec.max.x() = spec.min.x() + 500'000.0;
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("coarser LAS step"));
  spec.max.x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("finite bounds"));
  spec = Spec(dir / "a.las", false);
  spec.scale_m = 0.0;
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("positive number"));
  spec.scale_m = 1e-4;
  const auto writer = CreateLasWriter(spec);
  PointChunk chunk = RandomChunk(spec, 1, 5);
  for (const int station : {0, -1, 65536}) {
    EXPECT_THAT(ErrorOf([&] { writer->Write(chunk, station); }), HasSubstr("Point Source ID"));
  }
  chunk.x[0] = 1e7;
  EXPECT_THAT(ErrorOf([&] { writer->Write(chunk, 1); }), HasSubstr("a point at 10000000"));
  chunk.x[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf([&] { writer->Write(chunk, 1); }), HasSubstr("a point at nan"));
}

TEST(LasWriterLimits, RefusesAnOverflowBeforeAnythingIsWritten) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  spec.path = dir / "missing/a.las";
  // With bounds that fit the writer tries to write, and finds no folder.
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("create the directory"));
  spec.max.y() = spec.min.y() + 429'497.0;  // 2^32 steps of 0.1 mm are 429496.7296 m
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("in axis 1 with steps of 0.0001"));
  spec = Spec(dir / "a.las", false);
  spec.wkt = std::string(65535, 'w');
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("at most 65534 bytes"));
  spec.wkt = std::string("PROJCS\0[]", 9);
  EXPECT_THAT(ErrorOf([&] { CreateLasWriter(spec); }), HasSubstr("a WKT of 9 bytes"));
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(LasWriterCrs, IsAWktRecordByteByByte) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", true);
  // Units other than metres must not keep the file from being written.
  spec.wkt = "COMPD_CS[\"UTM + H\",\n  PROJCS[\"ETRS89 / UTM 32N\"],VERT_CS[\"foot\"]]";
  const PointChunk chunk = RandomChunk(spec, 100, 8);
  const auto writer = CreateLasWriter(spec);
  writer->Write(chunk, 2);
  writer->Finish();
  const LasBytes las(ReadBytes(spec.path));
  EXPECT_EQ(las.Unsigned(6, 2), 0x10U);
  EXPECT_EQ(las.Unsigned(100, 4), 1U);  // VLRs
  const std::size_t length = spec.wkt.size() + 1;
  EXPECT_EQ(las.Unsigned(96, 4), 375 + 54 + length);
  EXPECT_EQ(las.Unsigned(375, 2), 0U);
  EXPECT_EQ(las.Text(377, 16), "LASF_Projection");
  EXPECT_EQ(las.Unsigned(392, 1), 0U);
  EXPECT_EQ(las.Unsigned(393, 2), 2112U);
  EXPECT_EQ(las.Unsigned(395, 2), length);
  EXPECT_EQ(las.Text(397, 32), "OGC coordinate system WKT");
  EXPECT_EQ(las.Text(429, length), spec.wkt);
  EXPECT_EQ(las.Unsigned(428 + length, 1), 0U);  // the terminating NUL
  EXPECT_EQ(las.size(), 429 + length + 100 * 36);
  EXPECT_LE(std::abs(las.Point(99).x() - chunk.x[99]), 0.5001e-4);
  EXPECT_EQ(ReadWhole(spec.path).info.crs, spec.wkt);
}

TEST(LasWriterAttributes, ClassAndTimeAreWrittenWherePresent) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  PointChunk chunk = RandomChunk(spec, 2, 9);
  const auto writer = CreateLasWriter(spec);
  writer->Write(chunk, 1);
  chunk.classification = {2, 255};
  chunk.gps_time = {412345678.125, -1.5};
  writer->Write(chunk, 2);
  writer->Finish();
  const LasBytes las(ReadBytes(spec.path));
  EXPECT_EQ(las.Unsigned(6, 2), 0x11U);  // WKT, adjusted standard GPS time
  EXPECT_EQ(las.Unsigned(375 + 16, 1), 0U);
  EXPECT_EQ(las.Real(375 + 22), 0.0);
  EXPECT_EQ(las.Unsigned(375 + 2 * 30 + 16, 1), 2U);
  EXPECT_EQ(las.Real(375 + 2 * 30 + 22), 412345678.125);
  EXPECT_EQ(las.Unsigned(375 + 3 * 30 + 16, 1), 255U);
  EXPECT_EQ(las.Real(375 + 3 * 30 + 22), -1.5);
}

TEST(LasWriterSplit, WritesNumberedFilesThatTogetherHoldTheCloud) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", true);
  spec.max_points_per_file = 400;
  spec.wkt = "PROJCS[]";
  const PointChunk chunk = RandomChunk(spec, 1000, 10);
  const auto writer = CreateLasWriter(spec);
  writer->Write(chunk, 3);
  EXPECT_EQ(dir.FileCount(), 3U);  // temporary ones
  EXPECT_EQ(writer->Finish(), 1000U);
  EXPECT_EQ(dir.FileCount(), 3U);
  std::size_t k = 0;
  for (const WrittenFile& file : WrittenFiles(spec, 1000)) {
    const LasHeader header = VerifyLas(file.path);
    EXPECT_EQ(header.points, file.points);
    EXPECT_EQ(header.crs, "PROJCS[]");
    const LasBytes las(ReadBytes(file.path));
    for (std::size_t i = 0; i < file.points; ++i, ++k) {
      const Eigen::Vector3d truth(chunk.x[k], chunk.y[k], chunk.z[k]);
      ASSERT_LE((las.Point(i) - truth).cwiseAbs().maxCoeff(), 0.5001e-4);
    }
  }
  EXPECT_EQ(k, 1000U);
}

TEST(LasWriterSplit, OneFileKeepsItsNameWhereAllFits) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  spec.max_points_per_file = 100;
  const auto writer = CreateLasWriter(spec);
  writer->Write(RandomChunk(spec, 100, 11), 3);
  writer->Finish();
  EXPECT_EQ(VerifyLas(spec.path).points, 100U);
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(LasWriterSplit, LeavesNothingBehindWhenAbandoned) {
  const TempDir dir;
  {
    auto spec = Spec(dir / "a.las", false);
    spec.max_points_per_file = 10;
    CreateLasWriter(spec)->Write(RandomChunk(spec, 100, 12), 3);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(LasWriterLimits, LeavesNothingBehindWhenAbandoned) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  {
    const auto writer = CreateLasWriter(spec);
    writer->Write(RandomChunk(spec, 100000, 6), 1);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(LasWriterLimits, GivesUpWhileReadingAgain) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", false);
  int calls = 0;
  spec.between = [&calls] {
    if (++calls == 2) throw Interrupted();
  };
  {
    const auto writer = CreateLasWriter(spec);
    writer->Write(RandomChunk(spec, 100000, 6), 1);
    EXPECT_EQ(calls, 0);
    EXPECT_THROW(writer->Finish(), Interrupted);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(VerifyLas, FindsDamage) {
  const TempDir dir;
  auto spec = Spec(dir / "a.las", true);
  const auto writer = CreateLasWriter(spec);
  writer->Write(RandomChunk(spec, 1000, 7), 1);
  writer->Finish();
  const std::string good = ReadBytes(spec.path);
  const auto error = [&](const std::string& bytes) {
    return ErrorOf([&] { VerifyLas(dir.File("b.las", bytes)); });
  };
  EXPECT_THAT(error(good.substr(0, good.size() - 1)), HasSubstr("declared 1000 points"));
  EXPECT_THAT(error(good + std::string(36, '\0')), HasSubstr("36 bytes behind the last"));
  EXPECT_THAT(error(good.substr(0, 200)), HasSubstr("no LAS header"));
  std::string moved = good;
  moved[375 + 3] = '\x7f';  // the first point's x, upper byte
  EXPECT_THAT(error(moved), HasSubstr("as the points are"));
  const auto changed = [&](std::size_t at, char value) {
    std::string bytes = good;
    bytes[at] = value;
    return error(bytes);
  };
  EXPECT_THAT(changed(104, 3), HasSubstr("as Backsight writes"));
  EXPECT_THAT(changed(111, 1), HasSubstr("byte 111: a legacy count of 1; expected 0"));
  EXPECT_THAT(changed(263, 1), HasSubstr("byte 263: 1 points of a return; expected 0"));
  EXPECT_THAT(changed(375 + 14, 0x21), HasSubstr("a point of several returns"));
}

}  // namespace
}  // namespace backsight
