#include "io/e57/e57_cloud_writer.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

E57ScanSpec Scan(const std::string& guid, double shift) {
  E57ScanSpec scan;
  scan.guid = guid;
  scan.world_from_scan.translation.setConstant(shift);
  return scan;
}

PointChunk Points(std::vector<double> x) {
  PointChunk chunk;
  chunk.x = x;
  chunk.y = x;
  chunk.z = std::move(x);
  return chunk;
}

TEST(E57CloudWriter, GivesEveryStationAScanOfItsOwn) {
  const TempDir dir;
  const E57FileSpec file{dir / "a.e57", "{F}", "", "", {}, {}};
  std::map<int, E57ScanSpec> scans{{2, Scan("{2}", 2.0)}, {3, Scan("{3}", 3.0)}};
  scans[300] = Scan("{300}", 300.0);
  scans[300].rows = 5;
  scans[300].columns = 6;
  const auto writer = CreateE57CloudWriter(file, scans);
  writer->Write(Points({1.0}), 2);
  writer->Write(Points({}), 2);
  writer->Write(Points({0.1, 1e-300}), 2);
  writer->Write(Points({}), 3);
  PointChunk last = Points({-7.0});
  last.row = {4};
  last.column = {0};
  writer->Write(last, 300);
  EXPECT_EQ(writer->Finish(), 4U);
  const auto first = ReadWhole(file.path, 0);
  EXPECT_EQ(first.info.scan_count, 2);  // station 3 has no point
  EXPECT_EQ(first.info.guid, "{2}");
  EXPECT_EQ(first.points.x, (std::vector<double>{1.0, 0.1, 1e-300}));
  const auto second = ReadWhole(file.path, 1);
  EXPECT_EQ(second.info.guid, "{300}");
  EXPECT_EQ(second.info.world_from_scan->translation, Eigen::Vector3d::Constant(300.0));
  EXPECT_EQ(second.points.row, std::vector<std::int32_t>{4});
}

TEST(E57CloudWriter, LeavesNothingBehindWhenAbandoned) {
  const TempDir dir;
  {
    const auto writer =
        CreateE57CloudWriter({dir / "a.e57", "{F}", "", "", {}}, {{1, Scan("{1}", 0.0)}});
    writer->Write(Points({1.0}), 1);
    EXPECT_THROW(writer->Write(Points({1.0}), 2), InternalError);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
}

}  // namespace
}  // namespace backsight
