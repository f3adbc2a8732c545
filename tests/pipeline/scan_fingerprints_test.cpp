#include "pipeline/artifacts/scan_fingerprints.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "core/fingerprint.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;

/// Bytes that this process has read from files.
std::uint64_t BytesRead() {
  std::ifstream file("/proc/self/io");
  std::string word;
  std::uint64_t bytes = 0;
  while (file >> word && word != "rchar:") {
  }
  file >> bytes;
  return bytes;
}

class ScanFingerprintsTest : public ::testing::Test {
 protected:
  TempDir dir_;
  std::string scan_ = dir_.File("S1.e57", std::string(std::size_t{8} << 20U, 'a'));
  ArtifactStore store_{dir_ / "work"};
  ExecutionContext context_;
};

TEST_F(ScanFingerprintsTest, AFileIsReadOnceByManyThreads) {
  ScanFingerprints scans(store_);
  std::vector<std::string> found(8);
  const std::uint64_t before = BytesRead();
  {
    std::vector<std::jthread> threads;
    for (std::string& one : found) {
      threads.emplace_back([&] { one = scans.Of(scan_, context_).fingerprint; });
    }
  }
  EXPECT_LT(BytesRead() - before, 2 * fs::file_size(scan_));
  EXPECT_EQ(std::set<std::string>(found.begin(), found.end()),
            std::set<std::string>{FingerprintFile(scan_)});
}

TEST_F(ScanFingerprintsTest, WhatIsKnownIsNotReadAgainHoweverItIsSpelled) {
  EXPECT_EQ(ScanFingerprints(store_).Known(scan_), std::nullopt);
  EXPECT_FALSE(fs::exists(dir_ / "work"));
  const std::string fingerprint = ScanFingerprints(store_).Of(scan_, context_).fingerprint;
  fs::create_directory(dir_ / "more");
  const std::string relative = fs::proximate(scan_).string();
  const std::uint64_t before = BytesRead();
  for (const std::string& path : {scan_, relative, dir_ / "more/../S1.e57"}) {
    EXPECT_THAT(ScanFingerprints(store_).Known(path), Optional(fingerprint)) << path;
    EXPECT_EQ(ScanFingerprints(store_).Of(path, context_).fingerprint, fingerprint) << path;
  }
  EXPECT_LT(BytesRead() - before, fs::file_size(scan_));
}

TEST_F(ScanFingerprintsTest, AStoreThatMovesWithItsScansKnowsThem) {
  fs::create_directory(dir_ / "a");
  fs::rename(scan_, dir_ / "a/S1.e57");
  const ArtifactStore before(dir_ / "a/work");
  const std::string fingerprint =
      ScanFingerprints(before).Of(dir_ / "a/S1.e57", context_).fingerprint;
  fs::rename(dir_ / "a", dir_ / "b");
  const ArtifactStore after(dir_ / "b/work");
  EXPECT_THAT(ScanFingerprints(after).Known(dir_ / "b/S1.e57"), Optional(fingerprint));
}

TEST_F(ScanFingerprintsTest, AFileThatWasWrittenToIsNotKnown) {
  const ScanIdentity before = ScanFingerprints(store_).Of(scan_, context_);
  RequireUnchanged(scan_, before, context_);
  const fs::file_time_type time = fs::last_write_time(scan_);
  fs::last_write_time(scan_, time + std::chrono::seconds(5));
  EXPECT_EQ(ScanFingerprints(store_).Known(scan_), std::nullopt);
  RequireUnchanged(scan_, before, context_);  // the content is the same
  dir_.File("S1.e57", std::string(std::size_t{8} << 20U, 'b'));
  fs::last_write_time(scan_, time);  // as careless copies do
  EXPECT_EQ(ScanFingerprints(store_).Known(scan_), std::nullopt);
  EXPECT_THAT(ErrorOf([&] { RequireUnchanged(scan_, before, context_); }),
              AllOf(HasSubstr("S1.e57"), HasSubstr("it changed during the run")));
  EXPECT_NE(ScanFingerprints(store_).Of(scan_, context_).fingerprint, before.fingerprint);
}

}  // namespace
}  // namespace backsight
