#include "io/read_back.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "core/error.h"
#include "io/cloud_writer.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// What is said of a PLY file of two points if `written` is what it should hold.
std::string ComplaintAbout(const CloudContent& written) {
  const TempDir dir;
  CloudWriterSpec spec;
  spec.path = dir / "a.ply";
  PointChunk chunk;
  chunk.x = {1.0, 4.0};
  chunk.y = {2.0, 5.0};
  chunk.z = {3.0, 6.0};
  const auto writer = CreatePlyWriter(spec);
  writer->Write(chunk, 1);
  writer->Finish();
  try {
    RequireWritten("out/a.ply", *OpenScan(spec.path), written, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RequireWritten, TellsWhatIsOtherThanWritten) {
  CloudContent written;
  written.records = 2;
  written.AddPoint({1.0, 5.0, 3.0});
  written.AddPoint({4.0, 2.0, 6.0});
  EXPECT_EQ(ComplaintAbout(written), "");
  CloudContent more = written;
  more.records = 3;
  EXPECT_THAT(ComplaintAbout(more), HasSubstr("out/a.ply: 2 records when it is read again"));
  EXPECT_THAT(ComplaintAbout(more), HasSubstr("expected 3, as written"));
  CloudContent wider = written;
  wider.AddPoint({1.0, 2.0, 6.0001});
  EXPECT_THAT(ComplaintAbout(wider), HasSubstr("points from (1, 2, 3) to (4, 5, 6) when"));
  CloudContent elsewhere = written;
  elsewhere.crs = "ETRS89";
  EXPECT_THAT(ComplaintAbout(elsewhere), HasSubstr("expected 'ETRS89'"));
}

TEST(RequireWritten, CanBeGivenUp) {
  const TempDir dir;
  CloudWriterSpec spec;
  spec.path = dir / "a.pcd";
  spec.between = [] { throw Interrupted(); };
  PointChunk chunk;
  chunk.x = chunk.y = chunk.z = {1.0};
  const auto writer = CreatePcdWriter(spec);
  writer->Write(chunk, 1);
  EXPECT_THROW(writer->Finish(), Interrupted);
  EXPECT_FALSE(std::filesystem::exists(spec.path));
}

}  // namespace
}  // namespace backsight
