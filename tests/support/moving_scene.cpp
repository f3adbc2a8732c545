#include "tests/support/moving_scene.h"

#include <array>
#include <string>

#include "io/scan_reader.h"
#include "stages/features.h"
#include "stages/ingest.h"

namespace backsight {
namespace {

/// Hands out the returns of a simulated scan.
class SimulatedReader : public ScanReader {
 public:
  explicit SimulatedReader(const PointChunk& grid) {
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.x[i] == 0.0 && grid.y[i] == 0.0 && grid.z[i] == 0.0) continue;
      points_.x.push_back(grid.x[i]);
      points_.y.push_back(grid.y[i]);
      points_.z.push_back(grid.z[i]);
    }
    info_.path = "simulated";
    tally_.records = tally_.points = points_.size();
  }
  const ScanInfo& info() const override { return info_; }
  bool Next(PointChunk& chunk) override {
    chunk = points_;
    points_.Clear();
    return !chunk.empty();
  }
  const ScanTally& tally() const override { return tally_; }

 private:
  PointChunk points_;
  ScanInfo info_;
  ScanTally tally_;
};

void AddStations(const std::vector<Eigen::Vector2d>& places, Scene* scene) {
  for (const Eigen::Vector2d& place : places) {
    StationSite site;
    site.id = "S";
    site.id += std::to_string(scene->stations.size() + 1);
    site.position_m = place;
    scene->stations.push_back(site);
  }
}

}  // namespace

std::vector<PlacedSurface> ScannedCampaign::Placed() const {
  std::vector<PlacedSurface> placed;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    const ScannedStation& station = stations[s];
    placed.push_back({{station.model, station.features.normals, station.features.scanner_credible},
                      *station.index,
                      survey_from_station[s]});
  }
  return placed;
}

Scene BusyStreet(std::uint64_t seed) {
  Scene scene;
  scene.seed = seed;
  scene.ground.slope_deg = {1.0, 0.5};
  scene.ground.undulation_m = 0.2;
  scene.ground.kerbs = {{{-50.0, -6.0}, {50.0, -6.0}, 2.0, 0.12},
                        {{-50.0, 6.0}, {50.0, 6.0}, 2.0, 0.12}};
  scene.buildings = {{{-20.0, 15.0}, {18.0, 10.0}, 0.0},
                     {{8.0, 16.0}, {20.0, 12.0}, 3.0},
                     {{-12.0, -15.0}, {22.0, 10.0}, 180.0},
                     {{18.0, -14.0}, {16.0, 9.0}, 178.0}};
  for (const double x : {-30.0, -14.0, 2.0, 22.0}) {
    scene.trees.push_back({{x, 7.5}, 7.0, 2.0, 6000});
  }
  for (const double x : {-25.0, -5.0, 15.0}) scene.poles.push_back({{x, -6.5}});
  for (const double x : {-18.0, -8.0, 12.0}) scene.cars.push_back({{x, 4.2}, 0.0});
  scene.barriers = {{{-32.0, -8.0}, {-24.0, -8.0}, BarrierKind::kFence, 1.2, 0.1},
                    {{30.0, -9.0}, {30.0, -25.0}, BarrierKind::kWall, 2.0, 0.25}};
  scene.people = {8, {-28.0, -7.0}, {28.0, 7.0}};
  scene.traffic = {{2, {-40.0, -2.5}, {40.0, -2.5}}, {2, {40.0, 1.2}, {-40.0, 1.2}}};
  AddStations({{-24.0, -4.8}, {-9.0, 5.8}, {5.0, -5.0}, {20.0, 5.6}, {-2.0, -7.0}}, &scene);
  scene.scanner.step_deg = 0.3;
  return scene;
}

Scene BusyHall(std::uint64_t seed) {
  Scene scene;
  scene.seed = seed;
  Room hall;
  hall.size_m = {24.0, 14.0};
  hall.pillar_spacing_m = 6.0;
  hall.machines = 3;
  hall.tables = 4;
  hall.shelves = 3;
  scene.rooms = {hall};
  scene.people = {6, {-11.0, -6.0}, {11.0, 6.0}};
  AddStations({{-8.0, -3.0}, {-3.0, 4.0}, {3.0, -3.5}, {8.5, 3.0}}, &scene);
  scene.scanner.step_deg = 0.3;
  scene.scanner.orientation = Orientation::kRandomSo3;
  return scene;
}

ScannedCampaign ScanCampaign(const Scene& scene, const ExecutionContext& context) {
  const Campaign campaign = PrepareCampaign(scene);
  ScannedCampaign scanned{{}, {}, campaign.stations.front().world_from_station, campaign.ground};
  for (std::size_t s = 0; s < campaign.stations.size(); ++s) {
    ScannedStation station;
    station.scan = SimulateStation(campaign, s, context);
    SimulatedReader reader(station.scan.grid);
    station.model = IngestScan(campaign.stations[s].id, reader, {}, {}, context).model;
    station.features = ComputeFeatures(station.model, {}, context);
    station.index = std::make_unique<CloudIndex>(station.model);
    scanned.stations.push_back(std::move(station));
    scanned.survey_from_station.push_back(campaign.stations[s].survey_from_station);
  }
  return scanned;
}

}  // namespace backsight
