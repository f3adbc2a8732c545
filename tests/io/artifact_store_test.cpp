#include "io/artifact_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/error.h"
#include "tests/e2e/program.h"

namespace backsight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Kind = ArtifactState::Kind;

ArtifactKey MakeKey(const std::string& scan, double resolution_m) {
  ArtifactKey key;
  key.Add("stage", "station");
  key.Add("scan", scan);
  key.Add("resolution_m", resolution_m);
  key.AddLines("features.keypoints=1500\nfeatures.gamma=0.975\n");
  return key;
}

class ArtifactStoreTest : public ::testing::Test {
 protected:
  bool Holds(const std::string& name, const ArtifactKey& key) const {
    std::string bytes;
    return store_.Load(name, key, &bytes) && bytes == bytes_;
  }
  std::string PathOf(const std::string& name) const { return folder_ / (name + ".artifact"); }

  ScratchFolder folder_;
  std::vector<std::string> reports_;
  ArtifactStore store_{folder_ / "", [this](const std::string& text) { reports_.push_back(text); }};
  std::string bytes_ = std::string("line\n\0more", 10) + std::string(3'000'000, 'x');
};

TEST_F(ArtifactStoreTest, HoldsWhatBelongsToTheKeyAndNothingElse) {
  store_.Store("stations/S1/station", MakeKey("a", 0.1), bytes_);
  EXPECT_TRUE(Holds("stations/S1/station", MakeKey("a", 0.1)));
  EXPECT_FALSE(Holds("stations/S1/station", MakeKey("b", 0.1)));
  EXPECT_FALSE(Holds("stations/S1/station", MakeKey("a", 0.1 + 1e-17 + 1e-16)));
  EXPECT_FALSE(Holds("stations/S2/station", MakeKey("a", 0.1)));
  EXPECT_THAT(reports_, IsEmpty());
}

TEST_F(ArtifactStoreTest, PiecesAreStoredLikeTheWhole) {
  for (std::size_t i = 100; i < bytes_.size(); ++i) bytes_[i] = static_cast<char>(i % 251);
  const ArtifactKey key = MakeKey("a", 0.1);
  store_.Store("whole", key, bytes_);
  const auto write = [&](const auto& put) {
    const std::string_view all = bytes_;
    for (std::size_t begin = 0, size = 0; begin < all.size(); begin += size) {
      size = 1 + begin * 3;
      put(all.substr(begin, size));
    }
  };
  store_.Store("pieces", key, {bytes_.size(), write});
  EXPECT_TRUE(Holds("pieces", key));
  EXPECT_TRUE(ReadBytes(PathOf("pieces")) == ReadBytes(PathOf("whole")));
  for (const std::uint64_t wrong : {bytes_.size() - 1, bytes_.size() + 1}) {
    EXPECT_THROW(store_.Store("pieces", MakeKey("b", 0.1), {wrong, write}), InternalError);
    EXPECT_TRUE(Holds("pieces", key)) << "what was there stays";
  }
}

TEST_F(ArtifactStoreTest, ReplacesAndRemoves) {
  store_.Store("a/b", MakeKey("a", 0.1), "old");
  store_.Store("a/b", MakeKey("b", 0.1), bytes_);
  EXPECT_TRUE(Holds("a/b", MakeKey("b", 0.1)));
  EXPECT_FALSE(Holds("a/b", MakeKey("a", 0.1)));
  store_.Store("a/c", MakeKey("c", 0.1), "");
  store_.Remove("a/b");
  EXPECT_EQ(store_.Look("a/b", MakeKey("b", 0.1)).kind, Kind::kMissing);
}

TEST_F(ArtifactStoreTest, SaysWhatChanged) {
  store_.Store("n", MakeKey("a", 0.1), bytes_);
  EXPECT_EQ(store_.Look("n", MakeKey("a", 0.1)).kind, Kind::kUpToDate);
  const ArtifactState state = store_.Look("n", MakeKey("b", 0.2));
  EXPECT_EQ(state.kind, Kind::kOutdated);
  EXPECT_THAT(state.why, ElementsAre("resolution_m", "scan"));
  EXPECT_EQ(state.key_text, MakeKey("a", 0.1).text());
  EXPECT_TRUE(Holds("n", ArtifactKey::OfText(state.key_text)));
  EXPECT_EQ(store_.Look("m", MakeKey("b", 0.2)).kind, Kind::kMissing);
}

TEST_F(ArtifactStoreTest, FindsDamageAnywhere) {
  bytes_.resize(200);
  const ArtifactKey key = MakeKey("a", 0.1);
  store_.Store("n", key, bytes_);
  const std::string whole = ReadBytes(PathOf("n"));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    WriteBytes(PathOf("n"), damaged);
    EXPECT_FALSE(Holds("n", key)) << "byte " << i;
    WriteBytes(PathOf("n"), whole.substr(0, i));
    EXPECT_FALSE(Holds("n", key)) << "length " << i;
    EXPECT_EQ(store_.Look("n", key).kind, Kind::kDamaged) << "length " << i;
    EXPECT_THAT(reports_, SizeIs(2 * (i + 1))) << "byte " << i;  // its key is no way out
  }
  WriteBytes(PathOf("n"), whole + "x");
  EXPECT_FALSE(Holds("n", key));
  EXPECT_THAT(reports_.back(), HasSubstr("n.artifact is damaged"));
  WriteBytes(PathOf("n"), whole);
  EXPECT_TRUE(Holds("n", key));
}

TEST_F(ArtifactStoreTest, KeysTellTheirLinesApart) {
  ArtifactKey one, other;
  one.Add("name", "a\nscan: b");
  other.Add("name", "a");
  other.Add("scan", "b");
  EXPECT_NE(one.text(), other.text());
  EXPECT_NE(one.Digest(), other.Digest());
  EXPECT_EQ(MakeKey("a", 0.1).Digest(), MakeKey("a", 0.1).Digest());
}

TEST_F(ArtifactStoreTest, PlaceThatCannotBeWrittenIsAStorageFailure) {
  WriteBytes(folder_ / "file", "");
  const ArtifactStore store(folder_ / "file");
  EXPECT_THROW(store.Store("n", MakeKey("a", 0.1), bytes_), StorageFailure);
}

TEST(ArtifactStore, WithoutAFolderKeepsNothing) {
  const ArtifactStore none;
  std::string bytes;
  none.Store("n", MakeKey("a", 0.1), "bytes");
  EXPECT_FALSE(none.keeps());
  EXPECT_FALSE(none.Load("n", MakeKey("a", 0.1), &bytes));
}

TEST(DifferingLines, CountsEveryLineOfAName) {
  EXPECT_THAT(DifferingLines("m: 1\nm: 2\n", "m: 2\nm: 1\n"), IsEmpty());
  EXPECT_THAT(DifferingLines("m: 1\nm: 2\nk: 1\n", "m: 2\nk: 1\n"), ElementsAre("m"));
  EXPECT_THAT(DifferingLines("", "k: 1\n"), ElementsAre("k"));
}

}  // namespace
}  // namespace backsight
