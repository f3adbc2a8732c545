#include "pipeline/output_files.h"

#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>

#include "io/output_names.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(OutputNames, ComponentsAndPartsGoBehindTheName) {
  EXPECT_EQ(ComponentPath("o.d/a.b.las", 0), "o.d/a.b.las");
  EXPECT_EQ(ComponentPath("o.d/a.b.las", 1), "o.d/a.b_component2.las");
  EXPECT_EQ(PartPath(ComponentPath("a.las", 1), 3), "a_component2-3.las");
  EXPECT_EQ(MostComponents(2), 1);
  EXPECT_EQ(MostComponents(5), 2);
}

/// A run of four stations that wrote m.las, after one that had written more.
class StaleCloudsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    CloudOutput merged;
    merged.path = dir_ / "m.las";
    project_.outputs.merged = {merged};
    for (const char* id : {"S1", "S2", "S3", "S4"}) {
      project_.stations.emplace_back().id = id;
      project_.stations.back().scan = dir_.File(std::string(id) + ".las", "scan");
    }
    written_ = {{dir_.File("m.las", "cloud"), "LAS 1.4", "", 5}};
  }

  /// A file of the earlier run, as its manifest lists it.
  void Earlier(const std::string& name) {
    dir_.File(name, "of " + name);
    earlier_.push_back(DescribeFile(dir_ / name).value());
  }
  std::vector<std::string> Clear() {
    return ClearStaleClouds(project_, dir_.path(), earlier_, written_, ExecutionContext());
  }
  bool Exists(const std::string& name) const { return std::filesystem::exists(dir_ / name); }

  TempDir dir_;
  SurveyProject project_;
  std::vector<WrittenCloud> earlier_;
  std::vector<OutputRecord> written_;
};

TEST(DescribeFile, TimesCountFrom1970) {
  const TempDir dir;
  dir.File("a.las", "cloud");
  const auto described = DescribeFile(dir / "a.las");
  ASSERT_TRUE(described);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  EXPECT_NEAR(static_cast<double>(described->modified), static_cast<double>(now_ns), 60e9);
}

TEST_F(StaleCloudsTest, CloudsOfAnOutputThatIsNoLongerWantedAreNamed) {
  Earlier("full-1.las");
  Earlier("gone.las");
  std::filesystem::remove(dir_ / "gone.las");
  EXPECT_THAT(Clear(), ElementsAre(AllOf(HasSubstr("full-1.las"), Not(HasSubstr("gone.las")))));
  EXPECT_TRUE(Exists("full-1.las"));
}

TEST_F(StaleCloudsTest, WhatTheManifestListsIsRemoved) {
  for (const char* name : {"m_component2.las", "m-1.las", "m_component3-12.las"}) Earlier(name);
  EXPECT_THAT(Clear(), IsEmpty());
  for (const char* name : {"m_component2.las", "m-1.las", "m_component3-12.las"}) {
    EXPECT_FALSE(Exists(name)) << name;
  }
  EXPECT_TRUE(Exists("m.las"));
}

TEST_F(StaleCloudsTest, WhatIsNotProvablyOursStaysAndIsNamed) {
  dir_.File("m-1.las", "not listed");
  Earlier("m-2.las");
  dir_.File("m-2.las", "listed, but written anew by someone else");
  Earlier("m-4.las");
  dir_.File("m-4.las", "as m-4.las");  // as long as it was
  std::filesystem::last_write_time(
      dir_ / "m-4.las", std::filesystem::file_time_type::clock::now() + std::chrono::seconds(5));
  Earlier("m-3.las");
  std::filesystem::rename(dir_ / "m-3.las", dir_ / "kept.las");
  std::filesystem::create_symlink(dir_ / "kept.las", dir_ / "m-3.las");
  const std::vector<std::string> warnings = Clear();
  ASSERT_EQ(warnings.size(), 1U);
  for (const char* name : {"m-1.las", "m-2.las", "m-3.las", "m-4.las"}) {
    EXPECT_THAT(warnings[0], HasSubstr(dir_ / name));
    EXPECT_TRUE(Exists(name)) << name;
  }
}

TEST_F(StaleCloudsTest, OtherFilesAreNobodysBusiness) {
  for (const char* name : {"m_component2.e57", "m_old.las", "other.las", "m_component.las"}) {
    dir_.File(name, "not of any run");
  }
  project_.stations[1].scan = dir_.File("m-7.las", "scan");
  earlier_.push_back(DescribeFile(dir_ / "m-7.las").value());
  EXPECT_THAT(Clear(), IsEmpty());
  for (const char* name : {"m_component2.e57", "m_old.las", "other.las", "m-7.las"}) {
    EXPECT_TRUE(Exists(name)) << name;
  }
}

TEST_F(StaleCloudsTest, AResultIsNotRemovedWhereNothingTakesItsPlace) {
  Earlier("m.las");
  Earlier("m-1.las");
  written_.clear();
  const std::vector<std::string> warnings = Clear();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr(dir_ / "m.las"), HasSubstr(dir_ / "m-1.las")));
  EXPECT_TRUE(Exists("m.las") && Exists("m-1.las"));
}

TEST_F(StaleCloudsTest, CloudsOfStationsWithoutAPlaceAreNamed) {
  CloudOutput stations;
  stations.format = CloudFormat::kE57;
  stations.path = dir_.path();
  project_.outputs.stations = stations;
  written_.push_back({dir_.File("S1.e57", "now"), "E57", "", 5});
  Earlier("S3.e57");
  const std::vector<std::string> warnings = Clear();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("S3.e57"), Not(HasSubstr("S1.e57"))));
  EXPECT_TRUE(Exists("S3.e57"));
}

TEST_F(StaleCloudsTest, TheUsualCloudMeetsNoScan) {
  RequireFreeNames(project_, dir_.path());
  project_.outputs.merged.reset();
  RequireFreeNames(project_, dir_.path());
  project_.stations[3].scan = dir_.File("merged_component2.las", "scan");
  EXPECT_THAT(ErrorOf([&] { RequireFreeNames(project_, dir_.path()); }),
              HasSubstr("merged_component2.las, a scan"));
  project_.stations[3].scan = dir_ / "S4.las";
  project_.stations[3].id = "merged";
  CloudOutput stations;
  stations.path = dir_.path();
  project_.outputs.stations = stations;
  EXPECT_THAT(ErrorOf([&] { RequireFreeNames(project_, dir_.path()); }),
              HasSubstr("the cloud of station merged"));
}

}  // namespace
}  // namespace backsight
