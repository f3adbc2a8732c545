#include "stages/simulation/campaign.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "stages/simulation/moving_geometry.h"
#include "stages/simulation/ray_caster.h"
#include "stages/simulation/scene_geometry.h"

namespace backsight {
namespace {

/// A target is a body in front of what it is fixed to.
constexpr double kTargetStandoff = 0.02;

RigidTransform WorldFromStation(const Scene& scene, const GroundModel& ground,
                                const StationSite& site) {
  Random random(DeriveSeed(scene.seed, "orientation of " + site.id));
  const Scanner& scanner = scene.scanner;
  const double heading =
      scanner.orientation == Orientation::kLevelled ? site.heading_deg : random.Uniform(0.0, 360.0);
  RigidTransform pose = UprightFrame(ground.At(site.position_m, site.height_m), heading);
  if (scanner.orientation == Orientation::kRandomSo3) {
    pose.rotation = random.Rotation();
  } else {
    const double sigma = scanner.level_sigma_deg * std::numbers::pi / 180.0;
    const double tilt_x = sigma * random.Normal();
    const double tilt_y = sigma * random.Normal();
    pose.rotation = pose.rotation * ExpSo3({tilt_x, tilt_y, 0.0});
  }
  return pose;
}

Eigen::Vector3d Noise(double sigma, Random& random) {
  const double x = random.Normal();
  const double y = random.Normal();
  const double z = random.Normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

bool IsWithinView(const Scanner& scanner, const Eigen::Vector3d& in_station) {
  const double range = in_station.norm();
  if (range < scanner.min_range_m || range > scanner.max_range_m) return false;
  const double elevation_deg = std::asin(in_station.z() / range) * 180.0 / std::numbers::pi;
  return elevation_deg >= scanner.min_elevation_deg && elevation_deg <= scanner.max_elevation_deg;
}

}  // namespace

Campaign PrepareCampaign(const Scene& scene) {
  BACKSIGHT_CHECK(!scene.stations.empty(), "a scene needs a station");
  const GroundModel ground(scene.ground, scene.seed);
  Campaign campaign{scene, ground, BuildStaticMesh(scene, ground), {}};
  for (const StationSite& site : scene.stations) {
    campaign.stations.push_back({site.id, WorldFromStation(scene, ground, site), {}});
  }
  const RigidTransform survey_from_world = campaign.stations.front().world_from_station.Inverse();
  for (StationTruth& station : campaign.stations) {
    station.survey_from_station = survey_from_world * station.world_from_station;
  }
  campaign.stations.front().survey_from_station = RigidTransform();
  return campaign;
}

StationScan SimulateStation(const Campaign& campaign, std::size_t station,
                            const ExecutionContext& execution) {
  const StationTruth& truth = campaign.stations.at(station);
  // A town is more than a station sees: the rest would only slow the ray caster down.
  TriangleMesh mesh = TrianglesWithin(campaign.still, truth.world_from_station.translation,
                                      campaign.scene.scanner.max_range_m);
  AddMovingObjects(campaign.scene, campaign.ground, station, mesh);
  const RayCaster caster(std::move(mesh));
  return MeasureStation(caster, truth.world_from_station, campaign.scene.scanner,
                        DeriveSeed(campaign.scene.seed, "scan of " + truth.id), execution);
}

std::vector<SimulatedTarget> MeasureTargets(const Campaign& campaign) {
  if (campaign.scene.control.empty()) return {};
  const RayCaster caster(campaign.still);
  const RigidTransform survey_from_world = campaign.stations.front().world_from_station.Inverse();
  std::vector<SimulatedTarget> targets;
  for (const ControlSite& site : campaign.scene.control) {
    Random random(DeriveSeed(campaign.scene.seed, "target " + site.id));
    const Eigen::Vector3d world =
        campaign.ground.At(site.position_m.head<2>(), site.position_m.z());
    SimulatedTarget target;
    target.site = site;
    target.true_survey_m = survey_from_world * world;
    target.surveyed_m = target.true_survey_m + Noise(site.sigma_m, random);
    for (std::size_t i = 0; i < campaign.stations.size(); ++i) {
      const Eigen::Vector3d noise = Noise(site.measured_sigma_m, random);
      const RigidTransform& world_from_station = campaign.stations[i].world_from_station;
      const Eigen::Vector3d in_station = world_from_station.Inverse() * world;
      if (!IsWithinView(campaign.scene.scanner, in_station)) continue;
      const Eigen::Vector3d scanner = world_from_station.translation;
      const Eigen::Vector3d front = world - kTargetStandoff * (world - scanner).normalized();
      if (caster.IsFree(scanner, front)) target.measured.push_back({i, in_station + noise});
    }
    targets.push_back(std::move(target));
  }
  return targets;
}

}  // namespace backsight
