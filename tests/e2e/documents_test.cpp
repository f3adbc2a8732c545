#include <gtest/gtest.h>

#include "tests/e2e/program.h"

namespace backsight {
namespace {

TEST(Documents, OptionsPageIsWhatTheProgramPrints) {
  EXPECT_EQ(ReadBytes("docs/options.md"), RunProgram("options --markdown").out)
      << "run `make options-doc`";
}

TEST(CommandLine, RefusesNonsenseWithExitCodeTwo) {
  for (const char* arguments : {"", "frobnicate", "run", "run a.yaml --threads -3", "register a"}) {
    EXPECT_EQ(RunProgram(arguments).exit_code, 2) << arguments;
  }
  EXPECT_EQ(RunProgram("--version").exit_code, 0);
  EXPECT_EQ(RunProgram("run --help").exit_code, 0);
}

}  // namespace
}  // namespace backsight
