#include <gmock/gmock.h>

#include <cmath>

#include "io/cloud_writer.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

struct Writer {
  const char* name;
  std::unique_ptr<CloudWriter> (*create)(const CloudWriterSpec&);
  bool exact;      ///< coordinates as double, bit by bit
  bool has_times;  ///< class and GPS time are kept
};

void PrintTo(const Writer& writer, std::ostream* out) { *out << writer.name; }

class CloudWriters : public ::testing::TestWithParam<Writer> {};

struct RandomCloud {
  CloudWriterSpec spec;
  std::vector<PointChunk> chunks;
  PointChunk all;
};

PointChunk RandomChunk(const CloudWriterSpec& spec, bool has_times, Random& random) {
  PointChunk chunk;
  const std::size_t n = 1 + random.Index(2000);
  for (std::size_t i = 0; i < n; ++i) {
    chunk.x.push_back(random.Uniform(spec.min.x(), spec.max.x()));
    chunk.y.push_back(random.Uniform(spec.min.y(), spec.max.y()));
    chunk.z.push_back(random.Uniform(spec.min.z(), spec.max.z()));
    if (spec.has_intensity) chunk.intensity.push_back(static_cast<float>(random.Uniform()));
    if (spec.has_rgb) {
      const auto level = [&] { return static_cast<std::uint16_t>(257 * random.Index(256)); };
      chunk.rgb.push_back({level(), level(), level()});
    }
    if (!has_times) continue;
    chunk.classification.push_back(static_cast<std::uint8_t>(random.Index(256)));
    chunk.gps_time.push_back(random.Uniform(1e8, 5e8));
  }
  return chunk;
}

RandomCloud MakeCloud(const std::string& path, std::uint64_t seed, bool has_times) {
  Random random(seed);
  RandomCloud cloud;
  cloud.spec.path = path;
  cloud.spec.generator = "backsight 0.1.0";
  cloud.spec.has_intensity = random.Index(2) == 0;
  cloud.spec.has_rgb = random.Index(2) == 0;
  for (int a = 0; a < 3; ++a) {
    cloud.spec.min[a] = random.Uniform(-1e7, 1e7);
    cloud.spec.max[a] = cloud.spec.min[a] + random.Uniform(0.0, 1000.0);
  }
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (std::uint64_t i = 1 + random.Index(3); i > 0; --i) {
    cloud.chunks.push_back(RandomChunk(cloud.spec, has_times, random));
    const PointChunk& chunk = cloud.chunks.back();
    append(cloud.all.x, chunk.x);
    append(cloud.all.y, chunk.y);
    append(cloud.all.z, chunk.z);
    append(cloud.all.intensity, chunk.intensity);
    append(cloud.all.rgb, chunk.rgb);
    append(cloud.all.classification, chunk.classification);
    append(cloud.all.gps_time, chunk.gps_time);
  }
  return cloud;
}

TEST_P(CloudWriters, AreReadBack) {
  const TempDir dir;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RandomCloud cloud =
        MakeCloud(dir / (std::string("a.") + GetParam().name), seed, GetParam().has_times);
    const auto writer = GetParam().create(cloud.spec);
    for (const PointChunk& chunk : cloud.chunks) writer->Write(chunk, 7);
    EXPECT_EQ(writer->Finish(), cloud.all.size());
    const auto scan = ReadWhole(cloud.spec.path);
    ASSERT_EQ(scan.points.size(), cloud.all.size());
    EXPECT_EQ(scan.info.has_intensity, cloud.spec.has_intensity);
    EXPECT_EQ(scan.points.rgb, cloud.all.rgb);
    EXPECT_EQ(scan.points.classification, cloud.all.classification);
    EXPECT_EQ(scan.points.gps_time, cloud.all.gps_time);
    // Half a step of 0.1 mm, and what double leaves of it at 1e7 m.
    const double most = GetParam().exact ? 0.0 : 0.51e-4;
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      ASSERT_LE(std::abs(scan.points.x[i] - cloud.all.x[i]), most);
      ASSERT_LE(std::abs(scan.points.y[i] - cloud.all.y[i]), most);
      ASSERT_LE(std::abs(scan.points.z[i] - cloud.all.z[i]), most);
      if (!cloud.spec.has_intensity) continue;
      ASSERT_NEAR(scan.points.intensity[i], cloud.all.intensity[i], GetParam().exact ? 0.0 : 8e-6);
    }
  }
}

TEST_P(CloudWriters, LeaveNothingBehindWhenAbandoned) {
  const TempDir dir;
  {
    const RandomCloud cloud = MakeCloud(dir / "a.any", 1, false);
    const auto writer = GetParam().create(cloud.spec);
    writer->Write(cloud.all, 1);
    EXPECT_THAT(ErrorOf([&] { writer->Write(cloud.all, 0); }), HasSubstr("station number 0"));
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

INSTANTIATE_TEST_SUITE_P(All, CloudWriters,
                         ::testing::Values(Writer{"las", CreateLasWriter, false, true},
                                           Writer{"pcd", CreatePcdWriter, true, false},
                                           Writer{"ply", CreatePlyWriter, true, false}));

TEST(PcdWriter, FollowsTheFormatByteByByte) {
  const TempDir dir;
  CloudWriterSpec spec;
  spec.path = dir / "a.pcd";
  spec.has_intensity = true;
  spec.has_rgb = true;
  PointChunk chunk;
  chunk.x = {1.5};
  chunk.y = {-2.0};
  chunk.z = {5335000.123456789};
  chunk.intensity = {0.25F};
  chunk.rgb = {{65535, 0, 257}};
  const auto writer = CreatePcdWriter(spec);
  writer->Write(chunk, 300);
  EXPECT_EQ(writer->Finish(), 1U);
  std::string bytes =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
      "FIELDS x y z intensity rgb station\nSIZE 8 8 8 4 4 2\nTYPE F F F F F U\n"
      "COUNT 1 1 1 1 1 1\nWIDTH 00000000000000000001\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
      "POINTS 00000000000000000001\nDATA binary\n";
  for (const double value : {1.5, -2.0, 5335000.123456789}) Append(bytes, value);
  Append(bytes, 0.25F);
  Append(bytes, std::uint32_t{0x00FF0001});
  Append(bytes, std::uint16_t{300});
  EXPECT_EQ(ReadBytes(spec.path), bytes);
}

TEST(CloudWriters, PlyAndPcdKeepTheClassWhereAskedTo) {
  const TempDir dir;
  for (const auto& [name, create] :
       {std::pair{"a.ply", &CreatePlyWriter}, std::pair{"a.pcd", &CreatePcdWriter}}) {
    for (const bool wanted : {false, true}) {
      CloudWriterSpec spec;
      spec.path = dir / name;
      spec.has_classification = wanted;
      PointChunk chunk;
      chunk.x = chunk.y = chunk.z = {1.5};
      chunk.classification = {64};
      const auto writer = create(spec);
      writer->Write(chunk, 300);
      writer->Finish();
      std::string end;
      Append(end, 1.5);
      if (wanted) end += static_cast<char>(64);
      Append(end, std::uint16_t{300});
      const std::string bytes = ReadBytes(spec.path);
      EXPECT_EQ(bytes.substr(bytes.size() - end.size()), end);
      EXPECT_EQ(bytes.find("classification") != std::string::npos, wanted);
      const auto reader = OpenScan(spec.path);
      PointChunk read;
      EXPECT_TRUE(reader->Next(read));
      EXPECT_EQ(read.z, chunk.z);
    }
  }
}

TEST(WrittenFiles, AreNumberedWhereOneIsNotEnough) {
  CloudWriterSpec spec;
  spec.path = "out/town.v2.las";
  const auto names = [&](std::uint64_t most, std::uint64_t points) {
    spec.max_points_per_file = most;
    std::string text;
    for (const WrittenFile& file : WrittenFiles(spec, points)) {
      text += file.path + ":" + std::to_string(file.points) + " ";
    }
    return text;
  };
  EXPECT_EQ(names(0, 10), "out/town.v2.las:10 ");
  EXPECT_EQ(names(10, 10), "out/town.v2.las:10 ");
  EXPECT_EQ(names(10, 0), "out/town.v2.las:0 ");
  EXPECT_EQ(names(4, 10), "out/town.v2-1.las:4 out/town.v2-2.las:4 out/town.v2-3.las:2 ");
  EXPECT_EQ(names(5, 10), "out/town.v2-1.las:5 out/town.v2-2.las:5 ");
}

}  // namespace
}  // namespace backsight
