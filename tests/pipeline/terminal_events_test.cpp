#include "pipeline/terminal_events.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace backsight {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Verbosity = TerminalEvents::Verbosity;

/// Events that are shown in a string by a clock that stands until it is moved.
struct Shown {
  explicit Shown(bool is_terminal, Verbosity verbosity = Verbosity::kNormal)
      : events(verbosity, {.write = [this](std::string_view part) { text += part; },
                           .is_terminal = is_terminal,
                           .now = [this] { return now; }}) {}
  /// What was written since the last call.
  std::string Take() { return std::exchange(text, {}); }

  std::string text;
  std::chrono::steady_clock::time_point now;
  TerminalEvents events;
};

TEST(TerminalEvents, PlainOutputIsALineAtTheEndOfAStage) {
  Shown shown(/*is_terminal=*/false);
  shown.events.Progress("stations", 0, 4);
  shown.now += seconds(2);
  shown.events.Progress("stations", 2, 4);
  EXPECT_EQ(shown.Take(), "");
  shown.now += seconds(2);
  shown.events.Progress("stations", 4, 4);
  EXPECT_EQ(shown.Take(), "stations           4 of 4        1.0/s  4.0 s\n");
}

TEST(TerminalEvents, PlainOutputHasALineEveryThirtySecondsWhateverFinishes) {
  Shown shown(/*is_terminal=*/false);
  shown.events.Progress("stations", 0, 4);
  int lines = 0;
  for (int second = 1; second <= 95; ++second) {
    shown.now += seconds(1);
    shown.events.Tick();
    const std::string line = shown.Take();
    EXPECT_EQ(line.empty(), second % 30 != 0) << second << ": " << line;
    lines += line.empty() ? 0 : 1;
  }
  EXPECT_EQ(lines, 3);
  shown.now += seconds(25);  // 30 s after the last line, now by a unit that finishes
  shown.events.Progress("stations", 1, 4);
  EXPECT_EQ(shown.Take(),
            "stations           1 of 4     0.50/min  2 min 00 s, about 6 min 00 s left\n");
}

TEST(TerminalEvents, TicksSayNothingBetweenStages) {
  for (const bool is_terminal : {false, true}) {
    Shown shown(is_terminal);
    shown.now += seconds(100);
    shown.events.Tick();
    shown.events.Progress("stations", 0, 1);
    shown.events.Progress("stations", 1, 1);
    shown.Take();
    shown.now += seconds(100);
    shown.events.Tick();
    EXPECT_EQ(shown.Take(), "");
  }
}

TEST(TerminalEvents, TerminalLineIsRewrittenInPlace) {
  Shown shown(/*is_terminal=*/true);
  shown.events.Progress("stations", 0, 4);
  EXPECT_EQ(shown.Take(), "\r\x1b[Kstations           0 of 4               0.0 s");
  shown.now += milliseconds(50);
  shown.events.Progress("stations", 1, 4);
  EXPECT_EQ(shown.Take(), "") << "nobody reads that fast";
  shown.now += milliseconds(950);
  shown.events.Tick();
  EXPECT_EQ(shown.Take(),
            "\r\x1b[Kstations           1 of 4        1.0/s  1.0 s, about 3.0 s left");
  shown.events.Message(EventSink::Level::kWarning, "S3: no points");
  EXPECT_EQ(shown.Take(), "\r\x1b[Kwarning: S3: no points\n");
  shown.now += seconds(1);
  shown.events.Progress("stations", 4, 4);
  EXPECT_EQ(shown.Take(), "stations           4 of 4        2.0/s  2.0 s\n");
}

TEST(TerminalEvents, OlderNewsOfASlowerThreadIsNotShown) {
  Shown shown(/*is_terminal=*/true);
  shown.events.Progress("pairs", 5, 9);
  shown.Take();
  shown.now += seconds(1);
  shown.events.Progress("pairs", 4, 9);
  EXPECT_EQ(shown.Take(), "");
}

TEST(TerminalEvents, EveryStageEndsWithOneLine) {
  Shown shown(/*is_terminal=*/false);
  shown.events.Progress("stations", 0, 2);
  shown.now += seconds(1);
  shown.events.Progress("stations", 2, 2);
  shown.events.StageFinished("stations", 1.5);
  shown.events.StageFinished("report", 2.5);
  shown.events.Progress("map", 0, 2);
  shown.now += seconds(3);
  shown.events.StageFinished("map", 3.5);
  EXPECT_EQ(shown.Take(),
            "stations           2 of 2        2.0/s  1.0 s\n"
            "report                                 2.5 s\n"
            "map                0 of 2               3.0 s\n");
}

TEST(TerminalEvents, AbandonedStageLeavesNoLineAndNoTicks) {
  Shown shown(/*is_terminal=*/true);
  shown.events.Progress("stations", 0, 2);
  shown.Take();
  shown.events.Abandon();
  EXPECT_EQ(shown.Take(), "\r\x1b[K");
  shown.now += seconds(2);
  shown.events.Tick();
  EXPECT_EQ(shown.Take(), "");
}

TEST(TerminalEvents, QuietShowsWarningsOnlyAndVerboseShowsDetails) {
  for (const Verbosity verbosity : {Verbosity::kQuiet, Verbosity::kNormal, Verbosity::kVerbose}) {
    Shown shown(/*is_terminal=*/false, verbosity);
    shown.events.Message(EventSink::Level::kDebug, "d");
    shown.events.Message(EventSink::Level::kInfo, "i");
    shown.events.Message(EventSink::Level::kWarning, "w");
    shown.events.Message(EventSink::Level::kError, "e");
    const std::string details = verbosity == Verbosity::kVerbose ? "d\n" : "";
    const std::string news = verbosity == Verbosity::kQuiet ? "" : "i\n";
    EXPECT_EQ(shown.Take(), details + news + "warning: w\nerror: e\n");
    shown.events.Progress("map", 1, 1);
    shown.events.StageFinished("report", 1.0);
    EXPECT_EQ(shown.Take().empty(), verbosity == Verbosity::kQuiet);
  }
}

TEST(TerminalEvents, LinesOfManyThreadsStayWhole) {
  Shown shown(/*is_terminal=*/false);
  std::vector<std::jthread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (std::size_t i = 1; i <= 200; ++i) {
        shown.events.Message(EventSink::Level::kInfo, "whole");
        shown.events.Progress("pairs", i, 1000);
        shown.events.Tick();
      }
    });
  }
  threads.clear();
  std::string expected;
  for (int i = 0; i < 8 * 200; ++i) expected += "whole\n";
  EXPECT_EQ(shown.Take(), expected);
}

}  // namespace
}  // namespace backsight
