#include "tests/support/street_scene.h"

#include "stages/simulation/campaign.h"

namespace backsight {
namespace {

Scene Street() {
  Scene scene;
  scene.ground.size_m = 240.0;
  scene.ground.undulation_m = 0.1;
  scene.ground.kerbs = {{{-110.0, 6.0}, {110.0, 6.0}}, {{-110.0, -6.0}, {110.0, -6.0}}};
  for (int house = 0; house < 14; ++house) {
    const double x = -104.0 + 16.0 * house;
    for (const double side : {-1.0, 1.0}) {
      Building building;
      building.center_m = {x, side * (13.0 + house % 3)};
      building.size_m = {house % 4 == 0 ? 11.0 : 14.5, 10.0};
      building.heading_deg = side > 0.0 ? 0.0 : 180.0;
      building.wall_height_m = 7.0 + 1.5 * (house * 5 % 4);
      building.storeys = 2 + house % 3;
      building.roof = house % 2 == 0 ? RoofShape::kGable : RoofShape::kHip;
      scene.buildings.push_back(building);
      scene.trees.push_back({.position_m = {x + 7.0, side * 6.5}});
      scene.cars.push_back({.position_m = {x + 3.0, side * 4.0}, .heading_deg = 2.0 * house});
      scene.poles.push_back({.position_m = {x - 4.0, side * 6.2}, .heading_deg = side * -90.0});
    }
  }
  scene.scanner.max_range_m = 250.0;
  scene.scanner.step_deg = 0.057;
  scene.stations = {{.id = "street", .position_m = {1.0, 0.5}}};
  return scene;
}

}  // namespace

std::vector<Eigen::Vector3d> ScanStreet(const ExecutionContext& context) {
  const StationScan scan = SimulateStation(PrepareCampaign(Street()), 0, context);
  std::vector<Eigen::Vector3d> points;
  points.reserve(scan.returns);
  for (std::size_t i = 0; i < scan.grid.size(); ++i) {
    const Eigen::Vector3d point(scan.grid.x[i], scan.grid.y[i], scan.grid.z[i]);
    if (!point.isZero()) points.push_back(point);
  }
  return points;
}

}  // namespace backsight
