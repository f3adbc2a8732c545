#include "pipeline/json_events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/run_events.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class Recorder : public EventSink {
 public:
  void Message(Level, std::string_view text) override { told.emplace_back(text); }
  void Progress(std::string_view stage, std::size_t, std::size_t) override {
    told.emplace_back(stage);
  }
  void StageFinished(std::string_view stage, double) override { told.emplace_back(stage); }
  std::vector<std::string> told;
};

/// A log in memory whose clock stands at 12 ms past a second of 2026.
struct Logged {
  Recorder people;
  std::vector<std::string> lines;
  std::string fault;
  JsonEvents events{
      [this](std::string_view line) {
        if (fault.empty()) lines.emplace_back(line);
        return fault;
      },
      &people,
      [] {
        return std::chrono::system_clock::time_point(std::chrono::milliseconds(1'790'000'000'012));
      }};
};

TEST(JsonEvents, EveryEventIsOneLineWithItsFields) {
  Logged log;
  log.events.RunStarted({"a.yaml", "A", "out", 4, 2, "00ff"});
  log.events.Progress("stations", 1, 4);
  log.events.StageFinished("stations", 1.5);
  log.events.Message(EventSink::Level::kWarning, "two\nlines");
  log.events.RunInterrupted(SIGTERM);
  log.events.RunFinished(143, "Interrupted.", 2.25);
  const std::string start = R"({"schema_version":1,"time_utc":"2026-09-21T14:13:20.012Z","event":)";
  EXPECT_THAT(
      log.lines,
      ElementsAre(start + "\"run_started\",\"version\":\"" + kVersion + "\",\"git_hash\":\"" +
                      kGitHash +
                      "\",\"project\":\"a.yaml\",\"name\":\"A\",\"out\":\"out\",\"stations\":4,"
                      "\"threads\":2,\"options_fingerprint\":\"00ff\"}\n",
                  start + "\"progress\",\"stage\":\"stations\",\"done\":1,\"total\":4}\n",
                  start + "\"stage_finished\",\"stage\":\"stations\",\"seconds\":1.5}\n",
                  start + "\"message\",\"level\":\"warning\",\"text\":\"two\\nlines\"}\n",
                  start + "\"interrupted\",\"signal\":\"SIGTERM\"}\n",
                  start + "\"run_finished\",\"exit_code\":143,\"verdict\":\"Interrupted.\","
                          "\"wall_s\":2.25}\n"));
  EXPECT_TRUE(start.starts_with(JsonEvents::kMark));
}

TEST(JsonEvents, BytesThatAreNotUtf8AreReplaced) {
  Logged log;
  log.events.RunStarted({"caf\xe9.yaml", "A\xff", "\xc0\xaf", 4, 2, "00ff"});
  log.events.Message(EventSink::Level::kInfo, "caf\xe9.ptx\x01");
  EXPECT_EQ(json::parse(log.lines.at(0)).at("project"), "caf\uFFFD.yaml");
  EXPECT_EQ(json::parse(log.lines.at(1)).at("text"), "caf\uFFFD.ptx\x01");
}

TEST(JsonEvents, ProgressNeverGoesBackWithinAStage) {
  Logged log;
  for (const std::size_t done : {0, 2, 1, 3, 0, 1}) log.events.Progress("merge", done, 3);
  std::vector<int> shown;
  for (const std::string& line : log.lines) shown.push_back(json::parse(line).at("done"));
  EXPECT_THAT(shown, ElementsAre(0, 2, 3, 0, 1));
}

TEST(JsonEvents, LogThatCannotBeWrittenIsWarnedOfOnce) {
  Logged log;
  log.events.Progress("merge", 0, 3);
  log.fault = "No space left on device";
  log.events.Progress("merge", 1, 3);
  log.fault.clear();
  log.events.Progress("merge", 2, 3);
  EXPECT_EQ(log.lines.size(), 1U) << "no gaps in a log that looks whole";
  EXPECT_THAT(log.people.told, ElementsAre(HasSubstr("No space left on device")));
}

TEST(EventFanOut, ForwardsEverythingToAll) {
  Recorder first, second;
  EventFanOut all({&first, &second});
  all.Message(EventSink::Level::kInfo, "a");
  all.Progress("b", 1, 2);
  all.StageFinished("c", 1.0);
  EXPECT_THAT(first.told, ElementsAre("a", "b", "c"));
  EXPECT_EQ(second.told, first.told);
}

}  // namespace
}  // namespace backsight
