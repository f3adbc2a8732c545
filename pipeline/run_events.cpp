#include "pipeline/run_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "io/folder_lock.h"
#include "io/temporary_file.h"
#include "pipeline/resource_budget.h"
#include "pipeline/run_outputs.h"
#include "pipeline/slurm_client.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

/// Without what would break the line on a terminal or in a mail.
std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, '?');
  return text;
}

/// A summary that stdout does not take, as where its disk is full, is no silent success.
void PrintLine(const std::string& line) {
  const std::string text = line + "\n";
  const bool whole = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (std::fflush(stdout) == 0 && whole) return;
  fmt::print(stderr, "stdout did not take the summary line ({}): {}", std::strerror(errno), text);
}

std::string MakeFolderFor(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty()) MakeDirectories(folder.string());
  return path;
}

}  // namespace

EventFanOut::EventFanOut(std::vector<EventSink*> sinks) : sinks_(std::move(sinks)) {}

void EventFanOut::Message(Level level, std::string_view text) {
  for (EventSink* sink : sinks_) sink->Message(level, text);
}

void EventFanOut::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  for (EventSink* sink : sinks_) sink->Progress(stage, done, total);
}

void EventFanOut::StageFinished(std::string_view stage, double seconds) {
  for (EventSink* sink : sinks_) sink->StageFinished(stage, seconds);
}

void WarningMemory::Message(Level level, std::string_view text) {
  if (level != Level::kWarning) return;
  const std::scoped_lock lock(mutex_);
  warnings_.emplace(text);
}

bool WarningMemory::Holds(const std::string& warning) const {
  const std::scoped_lock lock(mutex_);
  return warnings_.contains(warning);
}

int ExitCodeOf(const std::exception& error) {
  if (dynamic_cast<const FolderInUse*>(&error) != nullptr) return kTryAgain;
  if (dynamic_cast<const SlurmUnreachable*>(&error) != nullptr) return kTryAgain;
  if (dynamic_cast<const TemporaryFailure*>(&error) != nullptr) return kTryAgain;
  if (dynamic_cast<const NoRoom*>(&error) != nullptr) return kNoRoom;
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return kNoRoom;
  const auto* storage = dynamic_cast<const StorageFailure*>(&error);
  if (storage != nullptr && storage->full()) return kNoRoom;
  return dynamic_cast<const InputError*>(&error) != nullptr ? kBadInput : kInternalFailure;
}

RunEvents::RunEvents(TerminalEvents::Verbosity verbosity, const std::string& log_json)
    : terminal_(verbosity),
      all_(log_json.empty() ? std::vector<EventSink*>{&terminal_} : OpenLog(log_json)),
      heartbeat_([this] { terminal_.Tick(); }) {
  // A reader of stderr or of the log that goes away must not end the run.
  std::signal(SIGPIPE, SIG_IGN);
}

std::vector<EventSink*> RunEvents::OpenLog(const std::string& path) {
  file_.emplace(MakeFolderFor(path), JsonEvents::kMark);
  log_.emplace([this](std::string_view line) { return file_->Append(line); }, &terminal_);
  return {&terminal_, &*log_};
}

void RunEvents::Started(const RunStart& start) {
  started_ = true;
  if (log_) log_->RunStarted(start);
}

int RunEvents::Finished(int exit_code, const std::string& verdict, const std::string& report) {
  return End(exit_code, verdict, " Report: " + report);
}

int RunEvents::Interrupted(int signal) {
  if (log_) log_->RunInterrupted(signal);
  return End(signal == SIGTERM ? kTerminated : kInterrupted,
             "Interrupted: what is finished is kept.", " The same command goes on from there.");
}

void RunEvents::Failed(const std::exception& error) {
  if (log_) log_->Message(EventSink::Level::kError, error.what());
  const std::string_view what = error.what();
  End(ExitCodeOf(error), fmt::format("Failed: {}", what.substr(0, what.find('\n'))),
      " What is finished is kept.");
}

int RunEvents::End(int exit_code, const std::string& verdict, const std::string& more) {
  terminal_.Abandon();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  if (log_) log_->RunFinished(exit_code, OneLine(verdict), wall.count());
  last_line_ = OneLine(verdict + more);
  exit_code_ = exit_code;
  if (started_) PrintLine(last_line_);
  return exit_code;
}

}  // namespace backsight
