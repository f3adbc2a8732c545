#include "pipeline/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>

#include "core/error.h"

namespace backsight {
namespace {

ProgramEnd Start(const std::vector<std::string>& words) {
  return RunProgram(words, ExecutionContext());
}

/// Ends when every program that was started meanwhile has ended.
class Survivors {
 public:
  Survivors() { EXPECT_EQ(::pipe(ends_.data()), 0); }
  ~Survivors() { ::close(ends_[0]); }
  Survivors(const Survivors&) = delete;
  Survivors& operator=(const Survivors&) = delete;

  void WaitForTheirEnd() {
    ::close(ends_[1]);
    char byte = 0;
    EXPECT_EQ(::read(ends_[0], &byte, 1), 0);
  }

 private:
  std::array<int, 2> ends_{};
};

TEST(ChildProcess, HandsWordsOnAsTheyAre) {
  const ProgramEnd end = Start({"printf", "%s|", "a b", "it's \"$HOME\"", "", "`x`;\n*"});
  EXPECT_EQ(end.fault, "");
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_EQ(end.out, "a b|it's \"$HOME\"||`x`;\n*|");
}

TEST(ChildProcess, TellsBothOutputsAndTheExitCode) {
  const ProgramEnd end = Start({"sh", "-c", "echo out; echo err >&2; exit 7"});
  EXPECT_EQ(end.exit_code, 7);
  EXPECT_EQ(end.out, "out\n");
  EXPECT_EQ(end.err, "err\n");
}

TEST(ChildProcess, TellsTheSignal) { EXPECT_EQ(Start({"sh", "-c", "kill -9 $$"}).exit_code, 137); }

TEST(ChildProcess, SaysWhyNothingWasStarted) {
  const ProgramEnd end = Start({"there-is-no-such-program"});
  EXPECT_EQ(end.fault, "No such file or directory");
  EXPECT_EQ(end.exit_code, -1);
}

TEST(ChildProcess, IsKilledWithAllItStartedWhenItsTimeIsOver) {
  for (const char* script : {"sleep 100000 & wait", "exec >&- 2>&-; sleep 100000 & wait"}) {
    Survivors survivors;
    EXPECT_THROW(RunProgram({"sh", "-c", script}, ExecutionContext().WithTimeLimit(0.2)),
                 OverTimeLimit);
    survivors.WaitForTheirEnd();
  }
}

TEST(ChildProcess, IsKilledWhenAStopIsRequested) {
  std::stop_source stop;
  Survivors survivors;
  stop.request_stop();
  EXPECT_THROW(RunProgram({"sleep", "100000"}, ExecutionContext(1, 0, nullptr, stop.get_token())),
               Interrupted);
  survivors.WaitForTheirEnd();
}

}  // namespace
}  // namespace backsight
