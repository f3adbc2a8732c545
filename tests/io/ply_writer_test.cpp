#include <gmock/gmock.h>

#include "io/cloud_writer.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

PointChunk Chunk(std::size_t n) {
  PointChunk chunk;
  for (std::size_t i = 0; i < n; ++i) {
    chunk.x.push_back(691000.0 + static_cast<double>(i) / 3.0);
    chunk.y.push_back(5335000.123456789);
    chunk.z.push_back(-static_cast<double>(i));
    chunk.intensity.push_back(static_cast<float>(i % 100) / 100.0F);
    const auto level = static_cast<std::uint16_t>(257 * (i % 256));
    chunk.rgb.push_back({level, 0, 65535});
  }
  return chunk;
}

TEST(PlyWriter, IsReadBackExactly) {
  const TempDir dir;
  for (const bool rich : {false, true}) {
    CloudWriterSpec spec;
    spec.path = dir / "a.ply";
    spec.has_intensity = rich;
    spec.has_rgb = rich;
    spec.generator = "backsight 0.1.0";
    const PointChunk chunk = Chunk(50000);
    const auto writer = CreatePlyWriter(spec);
    writer->Write(chunk, 1);
    writer->Write(chunk, 300);
    EXPECT_EQ(writer->Finish(), 100000U);
    const auto scan = ReadWhole(spec.path);
    ASSERT_EQ(scan.points.size(), 100000U);
    EXPECT_EQ(scan.info.has_rgb, rich);
    for (std::size_t i = 0; i < 50000; ++i) {
      for (const std::size_t k : {i, i + 50000}) {
        ASSERT_EQ(scan.points.x[k], chunk.x[i]);
        ASSERT_EQ(scan.points.y[k], chunk.y[i]);
        ASSERT_EQ(scan.points.z[k], chunk.z[i]);
        if (!rich) continue;
        ASSERT_EQ(scan.points.intensity[k], chunk.intensity[i]);
        ASSERT_EQ(scan.points.rgb[k], chunk.rgb[i]);
      }
    }
    const std::string bytes = ReadBytes(spec.path);
    EXPECT_THAT(bytes.substr(0, 200), HasSubstr("element vertex 00000000000000100000\n"));
    EXPECT_EQ(LoadBytes<std::uint16_t>(bytes.data() + bytes.size() - 2), 300U);
    EXPECT_EQ(dir.FileCount(), 1U);
  }
}

TEST(PlyWriter, RefusesBadStationsAndLeavesNothingBehind) {
  const TempDir dir;
  {
    CloudWriterSpec spec;
    spec.path = dir / "a.ply";
    const auto writer = CreatePlyWriter(spec);
    writer->Write(Chunk(10), 1);
    EXPECT_THAT(ErrorOf([&] { writer->Write(Chunk(1), 0); }), HasSubstr("station number 0"));
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

}  // namespace
}  // namespace backsight
