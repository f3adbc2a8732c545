#include "pipeline/latest_run.h"

#include <unistd.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/folder_lock.h"
#include "io/utc_text.h"

namespace backsight {
namespace {

std::string PathOf(const std::string& work) {
  return (std::filesystem::path(work) / "latest_run.json").string();
}

std::string Now() { return UtcText(std::chrono::system_clock::now()); }

void Write(const std::string& work, const LatestRun& run) {
  nlohmann::ordered_json json = {
      {"host", run.host}, {"process", run.process}, {"since", run.since_utc}};
  if (run.ending) {
    json["ended"] = run.ending->at_utc;
    json["exit_code"] = run.ending->exit_code;
    json["line"] = run.ending->line;
  }
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;  // paths are bytes
  try {
    WriteTextFile(PathOf(work), json.dump(2, ' ', false, kReplace) + "\n");
  } catch (const std::exception&) {
    std::error_code error;
    std::filesystem::remove(PathOf(work), error);  // better no note than an earlier run's
  }
}

}  // namespace

void NoteBeginning(const std::string& work) {
  Write(work, {HostName(), static_cast<int>(::getpid()), Now(), std::nullopt});
}

void NoteEnding(const std::string& work, int exit_code, const std::string& line) {
  std::optional<LatestRun> run = ReadLatestRun(work);
  if (!run) return;
  run->ending = RunEnding{Now(), exit_code, line};
  Write(work, *run);
}

std::optional<LatestRun> ReadLatestRun(const std::string& work) {
  std::ifstream file(PathOf(work));
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return std::nullopt;
  try {
    LatestRun run{json.at("host"), json.at("process"), json.at("since"), std::nullopt};
    if (json.contains("ended")) {
      run.ending = RunEnding{json.at("ended"), json.at("exit_code"), json.at("line")};
    }
    return run;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace backsight
