#include "pipeline/json_events.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <utility>

#include "pipeline/version.h"

namespace backsight {

using nlohmann::ordered_json;

/// The fields of an event that are its own.
struct JsonEvents::Line {
  ordered_json fields;
};

namespace {

constexpr int kSchemaVersion = 1;

std::string Utc(std::chrono::system_clock::time_point time) {
  using std::chrono::milliseconds;
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  const auto rest = std::chrono::duration_cast<milliseconds>(time - whole);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", whole, rest.count());
}

const char* Name(EventSink::Level level) {
  switch (level) {
    case EventSink::Level::kDebug:
      return "debug";
    case EventSink::Level::kInfo:
      return "info";
    case EventSink::Level::kWarning:
      return "warning";
    case EventSink::Level::kError:
      return "error";
  }
  return "";
}

}  // namespace

JsonEvents::JsonEvents(WriteLine write, EventSink* people, Now now)
    : write_(std::move(write)), people_(people), now_(std::move(now)) {}

void JsonEvents::RunStarted(const RunStart& start) {
  const std::scoped_lock lock(mutex_);
  Write("run_started", {{{"version", kVersion},
                         {"git_hash", kGitHash},
                         {"project", start.project},
                         {"name", start.name},
                         {"out", start.out},
                         {"stations", start.stations},
                         {"threads", start.threads},
                         {"options_fingerprint", start.options_fingerprint}}});
}

void JsonEvents::RunInterrupted(int signal) {
  const std::scoped_lock lock(mutex_);
  Write("interrupted", {{{"signal", signal == SIGTERM ? "SIGTERM" : "SIGINT"}}});
}

void JsonEvents::RunFinished(int exit_code, std::string_view verdict, double wall_s) {
  const std::scoped_lock lock(mutex_);
  Write("run_finished", {{{"exit_code", exit_code}, {"verdict", verdict}, {"wall_s", wall_s}}});
}

void JsonEvents::Message(Level level, std::string_view text) {
  const std::scoped_lock lock(mutex_);
  Write("message", {{{"level", Name(level)}, {"text", text}}});
}

void JsonEvents::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  const std::scoped_lock lock(mutex_);
  if (stage == stage_ && done != 0 && done < done_) return;  // a slower thread's older news
  stage_ = stage;
  done_ = done;
  Write("progress", {{{"stage", stage}, {"done", done}, {"total", total}}});
}

void JsonEvents::StageFinished(std::string_view stage, double seconds) {
  const std::scoped_lock lock(mutex_);
  Write("stage_finished", {{{"stage", stage}, {"seconds", seconds}}});
}

void JsonEvents::Write(std::string_view event, const Line& line) {
  if (broken_) return;
  ordered_json object = {
      {"schema_version", kSchemaVersion}, {"time_utc", Utc(now_())}, {"event", event}};
  object.update(line.fields);
  const std::string reason =
      write_(object.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
  if (reason.empty()) return;
  broken_ = true;
  people_->Message(Level::kWarning, "the event log goes no further: " + reason);
}

}  // namespace backsight
