#include "core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace backsight {
namespace {

using testing::HasSubstr;

TEST(InputError, SaysWhereWhatAndWhatToDo) {
  const InputError error({"scans/S1.ptx:12", "found 'x'", "a number", "check the export"});
  EXPECT_STREQ(error.what(), "scans/S1.ptx:12: found 'x'; expected a number; check the export");
  EXPECT_EQ(error.details().where, "scans/S1.ptx:12");
  EXPECT_EQ(error.details().found, "found 'x'");
  EXPECT_EQ(error.details().expected, "a number");
  EXPECT_EQ(error.details().remedy, "check the export");
}

TEST(InputError, LeavesEmptyPartsOut) {
  EXPECT_STREQ(InputError({"a.las", "", "", ""}).what(), "a.las");
  EXPECT_STREQ(InputError({"a.las", "empty file", "", ""}).what(), "a.las: empty file");
  EXPECT_STREQ(InputError({"a.las", "", "points", ""}).what(), "a.las; expected points");
  EXPECT_STREQ(InputError({"a.las", "", "", "scan again"}).what(), "a.las; scan again");
}

TEST(Check, NamesConditionPlaceAndReason) {
  EXPECT_NO_THROW(BACKSIGHT_CHECK(1 + 1 == 2, "arithmetic"));
  try {
    BACKSIGHT_CHECK(1 + 1 == 3, "arithmetic");
    FAIL() << "a broken invariant must throw";
  } catch (const InternalError& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 + 1 == 3"));
    EXPECT_THAT(error.what(), HasSubstr("error_test.cpp:"));
    EXPECT_THAT(error.what(), HasSubstr("arithmetic"));
  }
}

}  // namespace
}  // namespace backsight
