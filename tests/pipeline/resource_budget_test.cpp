#include "pipeline/resource_budget.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "io/e57/e57_writer.h"
#include "pipeline/artifacts/output_units.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kRecords = 2000;
constexpr std::uint64_t kLasBytes = 26;

class EstimateNeedsTest : public ::testing::Test {
 protected:
  EstimateNeedsTest() {
    project_.path = dir_ / "survey.yaml";
    StationSpec station;
    station.id = "A";
    station.scan = dir_ / "A.e57";
    E57Writer writer({station.scan, "{FILE}", "test", "", {}});
    writer.BeginScan({});
    PointChunk points;
    for (std::uint64_t i = 0; i < kRecords; ++i) {
      points.x.push_back(1.0);
      points.y.push_back(static_cast<double>(i));
      points.z.push_back(2.0);
    }
    writer.Write(points);
    writer.EndScan();
    writer.Finish();
    project_.stations.push_back(station);
    cloud_.path = dir_ / "out/merged.las";
    project_.outputs.merged = std::vector{cloud_};
  }

  /// All folders are on one disk.
  DiskNeed Need() const {
    const ResourceNeeds needs = EstimateNeeds(project_, dir_ / "out", store_);
    EXPECT_EQ(needs.disks.size(), 1U);
    return needs.disks.front();
  }

  TempDir dir_;
  SurveyProject project_;
  CloudOutput cloud_;
  ArtifactStore store_{dir_ / "work"};
};

TEST_F(EstimateNeedsTest, AQuarterOfTheRecordsOfAnE57IsPointsAtLeast) {
  EXPECT_GE(Need().least, kRecords / 4 * kLasBytes / 2);
  EXPECT_LT(Need().least, kRecords * kLasBytes / 2);
  EXPECT_GE(Need().likely, kRecords * kLasBytes);
}

TEST_F(EstimateNeedsTest, AQuarterOfTheLinesOfAPtsIsPointsAtLeast) {
  std::string text = std::to_string(kRecords) + "\n";
  for (std::uint64_t i = 0; i < kRecords; ++i) text += "1 2 3\n";
  project_.stations.front().scan = dir_.File("A.pts", text);
  EXPECT_GE(Need().least, kRecords / 4 * kLasBytes / 2);
}

TEST_F(EstimateNeedsTest, OnlyACloudThatLiesAsWrittenTakesNothing) {
  const std::uint64_t least = Need().least;
  WriteOnce(store_, cloud_.path, {}, ExecutionContext(), [&] {
    std::filesystem::create_directories(dir_ / "out");
    dir_.File("out/merged.las", "cloud");
    return OutputFiles{{{cloud_.path, "LAS 1.4", "", 1}}, {}};
  });
  EXPECT_LT(Need().least, least);
  dir_.File("out/merged.las", "another");
  EXPECT_EQ(Need().least, least);
  dir_.File("out/merged.las", "cloud");
  RunPlan plan;
  plan.outputs.push_back({cloud_.path, ArtifactState::Kind::kOutdated, "control P1"});
  EXPECT_EQ(EstimateNeeds(project_, dir_ / "out", store_, &plan).disks.front().least, least);
}

TEST_F(EstimateNeedsTest, ThinningTakesScratchSpaceOnce) {
  cloud_.thin_m = 0.01;
  project_.outputs.merged = std::vector{cloud_};
  const std::uint64_t one = Need().likely;
  EXPECT_GE(one, kRecords * 32);
  cloud_.path = dir_ / "out/again.las";
  project_.outputs.merged->push_back(cloud_);
  EXPECT_EQ(Need().likely, one);
}

TEST(RequireRoom, SaysWhatIsMissing) {
  ResourceNeeds needs;
  needs.physical_memory = 8'000'000'000;
  needs.disks.push_back({"/data", 2'000'000'000, 3'000'000'000, 1'000'000'000});
  try {
    RequireRoom(needs, 8.0, ExecutionContext());
    FAIL();
  } catch (const NoRoom& error) {
    EXPECT_THAT(error.what(), HasSubstr("/data: this run writes 2.0 GB at least, 1.0 GB are free"));
  }
}

}  // namespace
}  // namespace backsight
