#include "pipeline/child_process.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

TEST(ChildProcess, HandsWordsOnAsTheyAre) {
  const ProgramEnd end = RunProgram({"printf", "%s|", "a b", "it's \"$HOME\"", "", "`x`;\n*"});
  EXPECT_EQ(end.fault, "");
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_EQ(end.out, "a b|it's \"$HOME\"||`x`;\n*|");
}

TEST(ChildProcess, TellsBothOutputsAndTheExitCode) {
  const ProgramEnd end = RunProgram({"sh", "-c", "echo out; echo err >&2; exit 7"});
  EXPECT_EQ(end.exit_code, 7);
  EXPECT_EQ(end.out, "out\n");
  EXPECT_EQ(end.err, "err\n");
}

TEST(ChildProcess, TellsTheSignal) {
  EXPECT_EQ(RunProgram({"sh", "-c", "kill -9 $$"}).exit_code, 137);
}

TEST(ChildProcess, SaysWhyNothingWasStarted) {
  const ProgramEnd end = RunProgram({"there-is-no-such-program"});
  EXPECT_EQ(end.fault, "No such file or directory");
  EXPECT_EQ(end.exit_code, -1);
}

}  // namespace
}  // namespace backsight
