#include "pipeline/progress_file.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace backsight {
namespace {

std::string PathOf(const std::string& folder) {
  return (std::filesystem::path(folder) / "progress.json").string();
}

}  // namespace

ProgressFile::ProgressFile(const std::string& folder) : path_(PathOf(folder)) {
  std::error_code error;
  std::filesystem::remove(path_, error);
}

void ProgressFile::Message(Level, std::string_view) {}

void ProgressFile::StageFinished(std::string_view stage, double) {
  const std::scoped_lock lock(mutex_);
  place_ = "after ";
  place_ += stage;
}

std::string ProgressFile::place() const {
  const std::scoped_lock lock(mutex_);
  return place_;
}

void ProgressFile::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  const std::scoped_lock lock(mutex_);
  place_ = stage;
  const auto now = std::chrono::steady_clock::now();
  const bool recent = written_ && now - *written_ < std::chrono::seconds(1);
  if (recent && stage == stage_ && done < total) return;
  written_ = now;
  stage_ = stage;
  const nlohmann::json progress = {{"stage", stage}, {"done", done}, {"total", total}};
  std::ofstream(path_, std::ios::trunc) << progress.dump() << "\n";
}

std::optional<RunProgress> ReadProgress(const std::string& folder) {
  std::ifstream file(PathOf(folder));
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  const auto has = [&](const char* key, auto is_right) {
    return json.is_object() && json.contains(key) && is_right(json[key]);
  };
  const auto is_count = [](const nlohmann::json& v) { return v.is_number_unsigned(); };
  const auto is_text = [](const nlohmann::json& v) { return v.is_string(); };
  if (!has("stage", is_text) || !has("done", is_count) || !has("total", is_count)) return {};
  return RunProgress{json["stage"].get<std::string>(), json["done"].get<std::size_t>(),
                     json["total"].get<std::size_t>()};
}

}  // namespace backsight
