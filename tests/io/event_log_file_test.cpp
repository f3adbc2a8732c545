#include "io/event_log_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view kMark = "{\"a\":";

TEST(EventLogFile, LinesCanBeReadAtOnceAndReplaceAnEarlierLog) {
  const TempDir dir;
  const std::string path = dir.File("log", "{\"a\":0}\n{\"a\":1}\n");
  EventLogFile log(path, kMark);
  EXPECT_EQ(ReadBytes(path), "");
  EXPECT_EQ(log.Append("{\"a\":2}\n"), "");
  EXPECT_EQ(ReadBytes(path), "{\"a\":2}\n");
  EXPECT_EQ(log.Append("{\"a\":3}\n"), "");
  EXPECT_EQ(ReadBytes(path), "{\"a\":2}\n{\"a\":3}\n");
}

TEST(EventLogFile, WhatIsNoLogIsLeftAsItIs) {
  const TempDir dir;
  for (const char* text : {"schema_version: 1\n", "{", "{\n\"a\":1}"}) {
    const std::string path = dir.File("survey.yaml", text);
    EXPECT_THAT(ErrorOf([&] { EventLogFile(path, kMark); }), HasSubstr("is no event log"));
    EXPECT_EQ(ReadBytes(path), text);
  }
  const std::string empty = dir.File("empty", "");
  EXPECT_EQ(EventLogFile(empty, kMark).Append("{\"a\":1}\n"), "");
}

TEST(EventLogFile, NamesTheSystemsReason) {
  const TempDir dir;
  EXPECT_THAT(ErrorOf([&] { EventLogFile(dir / "missing/log", kMark); }),
              HasSubstr("No such file or directory"));
  EXPECT_THAT(ErrorOf([&] { EventLogFile(dir.path(), kMark); }), HasSubstr("Is a directory"));
}

TEST(EventLogFile, AnotherRunsLogIsNotTouched) {
  const TempDir dir;
  EventLogFile first(dir / "log", kMark);
  first.Append("{\"a\":1}\n");
  EventLogFile second(dir / "log", kMark);
  EXPECT_THAT(second.Append("{\"a\":2}\n"), HasSubstr("another run"));
  EXPECT_EQ(ReadBytes(dir / "log"), "{\"a\":1}\n");
}

TEST(EventLogFile, LineThatDoesNotFitLeavesNoPartOfItself) {
  const TempDir dir;
  EventLogFile log(dir / "log", kMark);
  const std::string line = "{\"a\":" + std::string(500, '1') + "}\n";
  // A limit on file size stands in for a full disk: both make the write itself fail.
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 700, old.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string first = log.Append(line);
  const std::string second = log.Append(line);
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(first, "");
  EXPECT_EQ(second, "File too large");
  EXPECT_EQ(ReadBytes(dir / "log"), line);
}

TEST(EventLogFile, DeviceMayBeFull) {
  EventLogFile log("/dev/full", kMark);
  EXPECT_EQ(log.Append("{\"a\":1}\n"), "No space left on device");
}

}  // namespace
}  // namespace backsight
