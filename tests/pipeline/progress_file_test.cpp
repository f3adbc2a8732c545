#include "pipeline/progress_file.h"

#include <gtest/gtest.h>

#include "tests/io/scan_files.h"

namespace backsight {
namespace {

TEST(ProgressFile, BeginsWithNothingOfAnEarlierRun) {
  const TempDir dir;
  ProgressFile(dir.path()).Progress("merge", 1, 1);
  ASSERT_TRUE(ReadProgress(dir.path()));
  const ProgressFile next(dir.path());
  EXPECT_FALSE(ReadProgress(dir.path()));
}

TEST(ProgressFile, KnowsWhereTheRunIs) {
  const TempDir dir;
  ProgressFile progress(dir.path());
  EXPECT_EQ(progress.place(), "start");
  progress.Progress("stations", 0, 4);
  EXPECT_EQ(progress.place(), "stations");
  progress.StageFinished("stations", 1.0);
  EXPECT_EQ(progress.place(), "after stations");
  progress.Progress("pairs", 0, 6);
  progress.Progress("pairs", 1, 6);
  EXPECT_EQ(progress.place(), "pairs");
  EXPECT_EQ(ReadProgress(dir.path())->stage, "pairs");
}

}  // namespace
}  // namespace backsight
