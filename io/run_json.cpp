#include "io/run_json.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace backsight {
namespace {

using nlohmann::ordered_json;

constexpr int kSchemaVersion = 1;

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

ordered_json ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json ToJson(const RigidTransform& transform) {
  const Eigen::Quaterniond q = transform.Quaternion();
  return {{"translation_m", ToJson(transform.translation)},
          {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

ordered_json ToJson(const std::optional<RigidTransform>& transform) {
  return transform ? ToJson(*transform) : ordered_json();
}

ordered_json ToJson(const Matrix6d& matrix) {
  ordered_json rows = ordered_json::array();
  for (int i = 0; i < 6; ++i) {
    ordered_json row = ordered_json::array();
    for (int j = 0; j < 6; ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

ordered_json ToJson(const std::optional<GroundPose>& ground) {
  if (!ground) return {};
  const PoseSigma sigma = SigmaOf(ground->enu_from_station, ground->covariance);
  return {{"enu_from_station", ToJson(ground->enu_from_station)},
          {"covariance", ToJson(ground->covariance)},
          {"sigma_position_m", ToJson(sigma.position_m)},
          {"sigma_worst_m", sigma.worst_position_m},
          {"sigma_rotation_deg", ToJson(sigma.rotation_deg)},
          {"crs_position", ToJson(ground->position)}};
}

ordered_json ToJson(const PoseRecord& pose) {
  const bool placed = pose.status == StationStatus::kRegistered;
  ordered_json json = {{"station", pose.station},
                       {"status", ToString(pose.status)},
                       {"reason", pose.reason},
                       {"component", placed ? ordered_json(pose.component) : ordered_json()},
                       {"links", pose.link_count},
                       {"survey_from_station", nullptr},
                       {"covariance", nullptr},
                       {"sigma_position_m", nullptr},
                       {"sigma_worst_m", nullptr},
                       {"sigma_rotation_deg", nullptr}};
  if (placed) json["survey_from_station"] = ToJson(pose.survey_from_station);
  if (placed && pose.covariance) {
    const PoseSigma sigma = *SigmaOf(pose);
    json["covariance"] = ToJson(*pose.covariance);
    json["sigma_position_m"] = ToJson(sigma.position_m);
    json["sigma_worst_m"] = sigma.worst_position_m;
    json["sigma_rotation_deg"] = ToJson(sigma.rotation_deg);
  }
  json["ground"] = placed ? ToJson(pose.ground) : ordered_json();
  return json;
}

ordered_json ToJson(const std::optional<HeldOutRecord>& held_out) {
  if (!held_out) return {};
  return {{"planes", held_out->planes},
          {"rms_before_m", held_out->rms_before_m},
          {"rms_after_m", held_out->rms_after_m},
          {"bias_before_m", held_out->bias_before_m},
          {"bias_after_m", held_out->bias_after_m}};
}

ordered_json ToJson(const LinkRecord& link) {
  const auto fine = [&](auto value) { return link.fine ? ordered_json(value) : ordered_json(); };
  const bool aligned = link.fine.has_value() || link.coarse.has_value();
  return {{"source", link.source},
          {"target", link.target},
          {"status", ToString(link.status)},
          {"reason", link.reason},
          {"target_from_source", ToJson(link.fine)},
          {"coarse_target_from_source", ToJson(link.coarse)},
          {"candidates", link.candidates},
          {"conflict", aligned ? ordered_json(link.conflict) : ordered_json()},
          {"agreement", aligned ? ordered_json(link.agreement) : ordered_json()},
          {"overlap", aligned ? ordered_json(link.overlap) : ordered_json()},
          {"rms_m", fine(link.rms_m)},
          {"fine_status", link.fine_status},
          {"correspondences", link.correspondences},
          {"consensus", link.consensus},
          {"consensus_null", link.consensus_null},
          {"planes", fine(link.planes)},
          {"weakest_sigma_m", fine(link.weakest_sigma_m)},
          {"iterations", fine(link.iterations)},
          {"network_weight", fine(link.network_weight)},
          {"network_residual_m", fine(link.network_residual_m)},
          {"network_residual_deg", fine(link.network_residual_deg)},
          {"loop_controlled",
           link.loop_controlled ? ordered_json(*link.loop_controlled) : ordered_json()},
          {"covariance", link.covariance ? ToJson(*link.covariance) : ordered_json()},
          {"held_out", ToJson(link.held_out)}};
}

ordered_json ToJson(const ScanRecord& scan) {
  return {{"station", scan.station},   {"path", scan.path},     {"format", scan.format},
          {"records", scan.records},   {"points", scan.points}, {"dropped", scan.dropped},
          {"moving", scan.moving},     {"leaves", scan.leaves}, {"keypoints", scan.keypoints},
          {"extent_m", scan.extent_m}, {"notes", scan.notes}};
}

ordered_json ToJson(const std::optional<Eigen::Vector3d>& v) {
  return v ? ToJson(*v) : ordered_json();
}

ordered_json ToJson(const SurveyPointRecord& point) {
  return {{"id", point.id},
          {"role", point.check ? "check" : "control"},
          {"excluded", point.excluded},
          {"sightings", point.sightings},
          {"residual_m", ToJson(point.residual_m)},
          {"free_residual_m", ToJson(point.free_residual_m)},
          {"w", ToJson(point.w)},
          {"checked", point.checked},
          {"sigma_m", ToJson(point.sigma_m)}};
}

ordered_json ToJson(const CheckRecord& check) {
  return {{"points", check.points},
          {"rmse_m", ToJson(check.rmse_m)},
          {"rmse_horizontal_m", check.rmse_horizontal_m},
          {"rmse_3d_m", check.rmse_3d_m},
          {"predicted_3d_m", check.predicted_3d_m}};
}

ordered_json ToJson(const GeoreferenceRecord& g) {
  ordered_json points = ordered_json::array();
  for (const SurveyPointRecord& point : g.points) points.push_back(ToJson(point));
  return {
      {"component", g.component},
      {"status", g.status},
      {"crs", g.crs},
      {"heights", g.heights},
      {"origin_deg_deg_m", ToJson(g.origin_deg_deg_m)},
      {"convergence_deg", g.convergence_deg},
      {"point_scale", g.point_scale},
      {"enu_from_survey", ToJson(g.enu_from_survey)},
      {"scale", g.scale},
      {"scale_test_ppm", g.scale_test ? ordered_json(g.scale_test->off_ppm) : ordered_json()},
      {"scale_sigma_ppm", g.scale_test ? ordered_json(g.scale_test->sigma_ppm) : ordered_json()},
      {"redundancy", g.redundancy},
      {"variance_factor", g.variance_factor},
      {"points", std::move(points)},
      {"check", ToJson(g.check)}};
}

ordered_json ToJson(const ComponentRecord& component) {
  return {{"component", component.component},
          {"stations", component.stations},
          {"links", component.links},
          {"redundancy", component.redundancy},
          {"sigma_factor", component.sigma_factor},
          {"refinement", component.refinement},
          {"planes", component.planes},
          {"observations", component.observations},
          {"rounds", component.rounds},
          {"iterations", component.iterations},
          {"anderson_accepted", component.anderson_accepted},
          {"plane_sigma_factor", component.plane_sigma_factor},
          {"weakest_station", component.weakest_station},
          {"weakest_sigma_m", component.weakest_sigma_m}};
}

ordered_json ToJson(const ClosureRecord& closure) {
  return {{"stations", closure.stations},
          {"coarse_m", closure.coarse_m},
          {"coarse_deg", closure.coarse_deg},
          {"fine_m", closure.fine_m},
          {"fine_deg", closure.fine_deg}};
}

ordered_json ToJson(const OutputRecord& output) {
  return {{"path", output.path},
          {"format", output.format},
          {"points", output.points ? ordered_json(*output.points) : ordered_json()}};
}

ordered_json ToJson(const GateRecord& gate) {
  return {
      {"name", gate.name}, {"limit", gate.limit}, {"value", gate.value}, {"passed", gate.passed}};
}

template <typename Record>
ordered_json ToJson(const std::vector<Record>& records) {
  ordered_json list = ordered_json::array();
  for (const Record& record : records) list.push_back(ToJson(record));
  return list;
}

std::vector<LinkRecord> TriedLinks(const std::vector<LinkRecord>& links) {
  std::vector<LinkRecord> tried;
  std::copy_if(links.begin(), links.end(), std::back_inserter(tried),
               [](const LinkRecord& link) { return link.status != LinkStatus::kSkipped; });
  return tried;
}

/// Pairs never tried, by reason; there may be some hundred thousand, and links.csv lists them.
ordered_json CountSkipped(const std::vector<LinkRecord>& links) {
  std::map<std::string, int> count;
  for (const LinkRecord& link : links) {
    if (link.status == LinkStatus::kSkipped) ++count[link.reason];
  }
  ordered_json json = ordered_json::object();
  for (const auto& [reason, n] : count) json[reason] = n;
  return json;
}

}  // namespace

std::string PosesJson(const std::vector<PoseRecord>& poses) {
  return Dump({{"schema_version", kSchemaVersion},
               {"covariance_order", "rotation (rad), translation (m); left perturbation"},
               {"poses", ToJson(poses)}},
              "poses.json");
}

std::string ReportJson(const RunRecord& run) {
  ordered_json network = ordered_json::object();
  for (const auto& [name, value] : run.network) network[name] = value;
  return Dump({{"schema_version", kSchemaVersion},
               {"project_name", run.project_name},
               {"version", run.version},
               {"verdict", run.verdict},
               {"exit_code", run.exit_code},
               {"gates", ToJson(run.gates)},
               {"network", std::move(network)},
               {"components", ToJson(run.components)},
               {"closures", ToJson(run.closures)},
               {"georeference", ToJson(run.georeference)},
               {"poses", ToJson(run.poses)},
               {"links", ToJson(TriedLinks(run.links))},
               {"skipped_pairs", CountSkipped(run.links)},
               {"scans", ToJson(run.scans)},
               {"outputs", ToJson(run.outputs)},
               {"warnings", run.warnings}},
              "report.json");
}

std::string ManifestJson(const ManifestRecord& manifest) {
  ordered_json inputs = ordered_json::array();
  for (const auto& [path, fingerprint] : manifest.inputs) {
    inputs.push_back({{"path", path}, {"fingerprint", fingerprint}});
  }
  ordered_json stages = ordered_json::array();
  for (const StageTime& stage : manifest.stages) {
    stages.push_back({{"stage", stage.stage}, {"seconds", stage.seconds}});
  }
  ordered_json clouds = ordered_json::array();
  for (const WrittenCloud& cloud : manifest.clouds) {
    clouds.push_back({{"path", cloud.path}, {"bytes", cloud.bytes}, {"modified", cloud.modified}});
  }
  return Dump({{"schema_version", kSchemaVersion},
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
