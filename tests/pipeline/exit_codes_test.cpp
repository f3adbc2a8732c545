#include <gtest/gtest.h>

#include <cerrno>

#include "io/temporary_file.h"
#include "pipeline/run_events.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

int CodeOfFileError(int error) {
  errno = error;
  try {
    ThrowFileError("out/merged.las", "writing failed");
  } catch (const StorageFailure& failure) {
    return ExitCodeOf(failure);
  }
}

TEST(ExitCodeOf, TellsWhatToTryAgainFromWhatToMend) {
  for (const int error : {EIO, ESTALE, ETIMEDOUT, ENOLCK}) {
    EXPECT_EQ(CodeOfFileError(error), kTryAgain) << error;
  }
  for (const int error : {ENOSPC, EDQUOT}) EXPECT_EQ(CodeOfFileError(error), kNoRoom) << error;
  for (const int error : {EACCES, EROFS, EISDIR, ENOENT}) {
    EXPECT_EQ(CodeOfFileError(error), kBadInput) << error;
  }
}

}  // namespace
}  // namespace backsight
