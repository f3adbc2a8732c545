#include "pipeline/artifacts/load_artifact.h"

#include <gmock/gmock.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(LoadArtifact, ReportsBytesThatHoldSomethingElse) {
  const TempDir dir;
  std::vector<std::string> reports;
  const ArtifactStore store(dir.path(), [&](const std::string& what) { reports.push_back(what); });
  ArtifactKey key;
  key.Add("stage", "test");
  store.Store("n", key, "abc");
  const auto decode = [](std::string_view bytes) { return FromBytes<double>(bytes); };
  EXPECT_EQ(LoadArtifact(store, "n", key, decode), std::nullopt);
  EXPECT_THAT(reports, ElementsAre(HasSubstr("n.artifact is damaged: the bytes end early")));
  EXPECT_EQ(LoadArtifact(store, "m", key, decode), std::nullopt);
  EXPECT_THAT(reports, ElementsAre(HasSubstr("n.artifact")));
}

}  // namespace
}  // namespace backsight
