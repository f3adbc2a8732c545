#include "pipeline/campaign_files.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <numbers>
#include <optional>

#include "core/error.h"
#include "io/geodetic_frame.h"

namespace backsight {
namespace {

/// Project files refuse a smaller levelling error.
constexpr double kMinLevelSigma = 1e-6;

std::string Triple(const Eigen::Vector3d& v, std::string_view separator) {
  return fmt::format("{:.9f}{}{:.9f}{}{:.9f}", v.x(), separator, v.y(), separator, v.z());
}

std::string_view RoleOf(const SimulatedTarget& target) {
  return target.site.check ? "check" : "control";
}

/// From the scene's world to the coordinates that its control is given in.
class ControlCoordinates {
 public:
  explicit ControlCoordinates(const std::optional<SceneCrs>& crs) {
    if (!crs) return;
    frame_.emplace(crs->horizontal, crs->vertical, "the scene's crs");
    frame_->SetOrigin(crs->origin);
    turn_ = ExpSo3({0.0, 0.0, crs->heading_deg * std::numbers::pi / 180.0});
  }
  Eigen::Vector3d Of(const Eigen::Vector3d& world) const {
    return frame_ ? frame_->CrsFromEnu(turn_ * world) : world;
  }

 private:
  std::optional<GeodeticFrame> frame_;
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();
};

std::string TargetEntries(const Campaign& campaign, std::span<const SimulatedTarget> targets,
                          bool check) {
  const ControlCoordinates coordinates(campaign.scene.crs);
  const RigidTransform& world_from_survey = campaign.stations.front().world_from_station;
  std::string text;
  for (const SimulatedTarget& target : targets) {
    if (target.site.check != check || target.measured.empty()) continue;
    const double sigma = target.site.sigma_m;
    text +=
        fmt::format("  - {{id: {}, crs: [{}], sigma_m: [{}, {}, {}], role: {},\n", target.site.id,
                    Triple(coordinates.Of(world_from_survey * target.surveyed_m), ", "), sigma,
                    sigma, sigma, RoleOf(target));
    text += "     measured: [";
    for (std::size_t i = 0; i < target.measured.size(); ++i) {
      const TargetMeasurement& m = target.measured[i];
      text += fmt::format("{}{{station: {}, xyz: [{}]}}", i == 0 ? "" : ",\n       ",
                          campaign.stations[m.station].id, Triple(m.xyz_m, ", "));
    }
    text += "]}\n";
  }
  return text;
}

std::string CrsEntry(const std::optional<SceneCrs>& crs) {
  if (!crs) return {};
  return fmt::format("crs: {{horizontal: {}{}}}\n", crs->horizontal,
                     crs->vertical.empty() ? "" : ", vertical: " + crs->vertical);
}

}  // namespace

std::string ScanFileName(const Scene& scene, const std::string& station_id) {
  switch (scene.format) {
    case CampaignFormat::kPtx:
      return "scans/" + station_id + ".ptx";
    case CampaignFormat::kPly:
      return "scans/" + station_id + ".ply";
    case CampaignFormat::kLas:
      return "scans/" + station_id + ".las";
  }
  throw InternalError("campaign format without a file name");
}

std::string TruthCsv(const Campaign& campaign) {
  std::string text = "station,component,status,tx_m,ty_m,tz_m,qw,qx,qy,qz\n";
  for (const StationTruth& station : campaign.stations) {
    const Eigen::Quaterniond q = station.survey_from_station.Quaternion();
    const Eigen::Vector3d& t = station.survey_from_station.translation;
    fmt::format_to(std::back_inserter(text),
                   "{},0,registered,{:.12f},{:.12f},{:.12f},{:.15f},{:.15f},{:.15f},{:.15f}\n",
                   station.id, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
  }
  return text;
}

std::string ControlCsv(const Campaign& campaign, std::span<const SimulatedTarget> targets) {
  std::string text =
      "id,role,station,x_m,y_m,z_m,sigma_m,true_x_m,true_y_m,true_z_m,"
      "measured_x_m,measured_y_m,measured_z_m,measured_sigma_m\n";
  for (const SimulatedTarget& target : targets) {
    for (const TargetMeasurement& m : target.measured) {
      fmt::format_to(
          std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", target.site.id, RoleOf(target),
          campaign.stations[m.station].id, Triple(target.surveyed_m, ","), target.site.sigma_m,
          Triple(target.true_survey_m, ","), Triple(m.xyz_m, ","), target.site.measured_sigma_m);
    }
  }
  return text;
}

std::string ProjectYaml(const Campaign& campaign, std::span<const SimulatedTarget> targets) {
  const Scene& scene = campaign.scene;
  std::string text = fmt::format(
      "# Simulated campaign; truth.csv holds the true poses.\n"
      "schema_version: 1\nname: {}\n{}stations:\n",
      scene.name, CrsEntry(scene.crs));
  std::string levelled;
  if (scene.scanner.orientation != Orientation::kRandomSo3) {
    levelled = fmt::format(", levelled: true, level_sigma_deg: {}",
                           std::max(kMinLevelSigma, scene.scanner.level_sigma_deg));
  }
  for (const StationTruth& station : campaign.stations) {
    fmt::format_to(std::back_inserter(text), "  - {{id: {}, scan: {}{}}}\n", station.id,
                   ScanFileName(scene, station.id), levelled);
  }
  text += "outputs:\n  merged: [{format: las, path: out/merged.las, thin_m: 0.01}]\n";
  text += "gates: {require_all_stations: true}\n";
  const std::string control = TargetEntries(campaign, targets, false);
  const std::string check = TargetEntries(campaign, targets, true);
  if (control.empty() && check.empty()) return text;
  text += "control:\n" + control;
  if (!check.empty()) text += "  # Check points, never used for fitting:\n" + check;
  return text;
}

}  // namespace backsight
