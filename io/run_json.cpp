#include "io/run_json.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/report_document.h"
#include "io/report_fields.h"

namespace backsight {
namespace {

using nlohmann::ordered_json;

constexpr int kPosesVersion = 1;
constexpr int kManifestVersion = 1;

/// JSON has no NaN; the library would write null in its place.
void RequireFinite(const ordered_json& value, const std::string& where) {
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    throw InternalError(fmt::format("{} is {}", where, value.get<double>()));
  }
  if (!value.is_structured()) return;
  for (const auto& [key, child] : value.items()) RequireFinite(child, where + "/" + key);
}

std::string Dump(const ordered_json& document, const std::string& name) {
  RequireFinite(document, name);
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

template <typename Value>
ordered_json ToJson(const Value& value);

/// A number, text, list or motion; what has keys is a record.
template <typename Value>
requires std::is_arithmetic_v<Value> ordered_json Json(const Value& value) { return value; }

ordered_json Json(const std::string& text) { return text; }

template <typename Word>
requires std::is_enum_v<Word> ordered_json Json(const Word& word) { return ToString(word); }

template <int n>
ordered_json Json(const Eigen::Matrix<double, n, 1>& v) {
  ordered_json list = ordered_json::array();
  for (int i = 0; i < n; ++i) list.push_back(v[i]);
  return list;
}

ordered_json Json(const RigidTransform& transform) {
  const Eigen::Quaterniond q = transform.Quaternion();
  return {{"translation_m", Json(transform.translation)},
          {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

ordered_json Json(const Matrix6d& matrix) {
  ordered_json rows = ordered_json::array();
  for (int i = 0; i < 6; ++i) rows.push_back(Json(Vector6d(matrix.row(i))));
  return rows;
}

template <typename Value>
ordered_json Json(const std::optional<Value>& value) {
  return value ? ToJson(*value) : ordered_json();
}

template <typename List>
ordered_json JsonList(const List& values) {
  ordered_json list = ordered_json::array();
  for (const auto& value : values) list.push_back(ToJson(value));
  return list;
}

template <typename Value>
ordered_json Json(const std::vector<Value>& values) {
  return JsonList(values);
}

template <typename Value, std::size_t n>
ordered_json Json(const std::array<Value, n>& values) {
  return JsonList(values);
}

template <typename Value>
ordered_json Json(const std::vector<std::pair<std::string, Value>>& values) {
  ordered_json object = ordered_json::object();
  for (const auto& [key, value] : values) object[key] = value;
  return object;
}

/// A visitor of VisitFields that fills a JSON object.
class Writer {
 public:
  explicit Writer(ordered_json object) : object_(std::move(object)) {}
  ordered_json Finish() { return std::move(object_); }

  template <typename Value>
  void Field(const char* key, const Value& value) {
    object_[key] = ToJson(value);
  }
  template <typename Value>
  void FieldIf(bool shown, const char* key, const Value& value) {
    object_[key] = shown ? ToJson(value) : ordered_json();
  }
  void Word(const char* key, bool value, const char* yes, const char* no) {
    object_[key] = value ? yes : no;
  }
  template <typename Function>
  void Derived(const char* key, const Function& function) {
    object_[key] = ToJson(function());
  }

 private:
  ordered_json object_;
};

template <typename Value>
ordered_json ToJson(const Value& value) {
  if constexpr (requires { Json(value); }) {
    return Json(value);
  } else {
    Writer writer(ordered_json::object());
    VisitFields(writer, value);
    return writer.Finish();
  }
}

}  // namespace

ReportDocument MakeReportDocument(RunRecord run, std::vector<PictureRecord> pictures) {
  ReportDocument document{std::move(run), {}, std::move(pictures)};
  std::map<std::string, std::uint64_t> count;
  std::erase_if(document.run.links, [&](const LinkRecord& link) {
    if (link.status != LinkStatus::kSkipped) return false;
    ++count[link.reason];
    return true;
  });
  document.skipped_pairs.assign(count.begin(), count.end());
  return document;
}

std::string PosesJson(const std::vector<PoseRecord>& poses) {
  return Dump({{"schema_version", kPosesVersion},
               {"covariance_order", "rotation (rad), translation (m); left perturbation"},
               {"poses", ToJson(poses)}},
              "poses.json");
}

std::string ReportJson(const ReportDocument& document) {
  Writer writer(ordered_json{{"schema_version", kReportVersion}});
  VisitFields(writer, document);
  return Dump(writer.Finish(), "report.json");
}

std::string ManifestJson(const ManifestRecord& manifest) {
  ordered_json inputs = ordered_json::array();
  for (const auto& [path, fingerprint] : manifest.inputs) {
    inputs.push_back({{"path", path}, {"fingerprint", fingerprint}});
  }
  ordered_json stages = ordered_json::array();
  for (const StageTime& stage : manifest.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"seconds", stage.seconds},
                      {"processor_s", stage.processor_s},
                      {"idle_share", stage.idle_share}});
  }
  ordered_json clouds = ordered_json::array();
  for (const WrittenCloud& cloud : manifest.clouds) {
    clouds.push_back({{"path", cloud.path}, {"bytes", cloud.bytes}, {"modified", cloud.modified}});
  }
  return Dump({{"schema_version", kManifestVersion},
               {"version", manifest.version},
               {"git_hash", manifest.git_hash},
               {"project_path", manifest.project_path},
               {"started_utc", manifest.started_utc},
               {"wall_s", manifest.wall_s},
               {"peak_memory_mb", manifest.peak_memory_mb},
               {"threads", manifest.threads},
               {"options", manifest.options},
               {"inputs", std::move(inputs)},
               {"stages", std::move(stages)},
               {"clouds", std::move(clouds)}},
              "manifest.json");
}

std::vector<WrittenCloud> ReadWrittenClouds(const std::string& manifest_path) {
  std::ifstream file(manifest_path);
  const ordered_json manifest =
      ordered_json::parse(file, /*cb=*/nullptr, /*allow_exceptions=*/false);
  if (!manifest.is_object() || !manifest.contains("clouds")) return {};
  std::vector<WrittenCloud> clouds;
  for (const ordered_json& cloud : manifest["clouds"]) {
    if (!cloud.is_object()) continue;
    const auto has = [&](const char* key, auto is_right) {
      return cloud.contains(key) && is_right(cloud[key]);
    };
    const bool whole = has("path", [](const auto& v) { return v.is_string(); }) &&
                       has("bytes", [](const auto& v) { return v.is_number_unsigned(); }) &&
                       has("modified", [](const auto& v) { return v.is_number_integer(); });
    if (!whole) continue;
    clouds.push_back({cloud["path"].get<std::string>(), cloud["bytes"].get<std::uint64_t>(),
                      cloud["modified"].get<std::int64_t>()});
  }
  return clouds;
}

std::optional<LastRun> ReadLastRun(const std::string& out_directory) {
  std::ifstream file(std::filesystem::path(out_directory) / "report.json");
  const ordered_json report = ordered_json::parse(file, /*cb=*/nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.contains("verdict") || !report.contains("exit_code"))
    return {};
  const ordered_json& verdict = report["verdict"];
  const ordered_json& exit_code = report["exit_code"];
  if (!verdict.is_string() || !exit_code.is_number_integer()) return {};
  return LastRun{verdict.get<std::string>(), exit_code.get<int>()};
}

}  // namespace backsight
