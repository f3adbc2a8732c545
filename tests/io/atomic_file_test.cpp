#include "io/atomic_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const TempDir dir;
  const std::string path = dir.File("a.txt", "old");
  AtomicFile file(path);
  file.Write("new ");
  file.Write(std::string(3'000'000, 'x'));
  EXPECT_EQ(ReadBytes(path), "old");
  file.Write("end");
  file.Overwrite(0, "NEW");
  file.Sync();
  EXPECT_EQ(ReadBytes(file.temporary_path()).size(), 3'000'007U);
  EXPECT_EQ(ReadBytes(path), "old");
  file.Commit();
  EXPECT_EQ(ReadBytes(path), "NEW " + std::string(3'000'000, 'x') + "end");
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(AtomicFile, LeavesNothingBehindWhenAbandoned) {
  const TempDir dir;
  {
    AtomicFile file(dir / "a.txt");
    file.Write(std::string(2'000'000, 'x'));
    EXPECT_EQ(dir.FileCount(), 1U);
  }
  EXPECT_EQ(dir.FileCount(), 0U);
  const std::string old = dir.File("old.txt", "old");
  { AtomicFile(old).Write("new"); }
  EXPECT_EQ(ReadBytes(old), "old");
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(AtomicFile, TwoWritersDoNotMix) {
  const TempDir dir;
  AtomicFile a(dir / "a.txt");
  AtomicFile b(dir / "a.txt");
  a.Write("aaa");
  b.Write("b");
  a.Commit();
  b.Commit();
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "b");
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(AtomicFile, NamesTheSystemsReason) {
  const TempDir dir;
  EXPECT_THAT(ErrorOf([&] { AtomicFile(dir / "missing/a.txt"); }),
              HasSubstr("missing/a.txt: cannot be written: No such file or directory; create"));
  EXPECT_THAT(ErrorOf([&] { AtomicFile(dir.path()); }), HasSubstr("Is a directory"));
  const std::string file = dir.File("file", "");
  EXPECT_THAT(ErrorOf([&] { AtomicFile(file + "/a.txt"); }), HasSubstr("Not a directory"));
}

TEST(AtomicFile, ReportsAFileThatCannotGrow) {
  const TempDir dir;
  // A limit on file size stands in for a full disk: both make the write itself fail.
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 1000, old.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = ErrorOf([&] { WriteTextFile(dir / "a.txt", std::string(5000, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(error, HasSubstr("writing failed: File too large; free disk space"));
  EXPECT_EQ(dir.FileCount(), 0U);
}

TEST(AtomicFile, WaitsSealedForItsFinalName) {
  const TempDir dir;
  {
    AtomicFile kept(dir / "a.txt");
    AtomicFile dropped(dir / "b.txt");
    for (AtomicFile* file : {&kept, &dropped}) {
      file->Write("text");
      file->Seal();
      EXPECT_EQ(ReadBytes(file->temporary_path()), "text");
    }
    kept.Retarget(dir / "a-1.txt");
    kept.Commit();
    EXPECT_EQ(ReadBytes(dir / "a-1.txt"), "text");
  }
  EXPECT_EQ(dir.FileCount(), 1U);
}

TEST(WriteTextFile, WritesTheWholeText) {
  const TempDir dir;
  WriteTextFile(dir / "a.txt", "line\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "line\n");
  WriteTextFile(dir / "a.txt", "");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "");
}

}  // namespace
}  // namespace backsight
