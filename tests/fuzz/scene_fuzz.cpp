#include "io/scene_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

constexpr const char* kStations = R"(schema_version: 1
name: demo
seed: 20240917
format: las
stations:
  - {id: S1, position_m: [0, 0]}
  - {id: S2, position_m: [4, -7.5], height_m: 1.6, heading_deg: 33}
)";
constexpr const char* kObjects = R"(ground:
  size_m: 110
  slope_deg: [0.6, -0.3]
  kerbs: [{from_m: [-30, 11.6], to_m: [14.0, 11.6], width_m: 2.8, height_m: 0.12}]
buildings:
  - {center_m: [-9, 19], size_m: [24, 12], heading_deg: 0, wall_height_m: 10.5, storeys: 3,
     style: masonry, roof: gable, bay_m: 3.1, window_depth_m: 0.22, doors: 2}
barriers: [{from_m: [-14, -21], to_m: [-6.2, -21.6], kind: wall, height_m: 2.1}]
poles: [{position_m: [-13, 10.6], height_m: 6.5, heading_deg: -80, lamp: false}]
trees: [{position_m: [-3, 2.5], height_m: 8.5, crown_radius_m: 2.4, leaves: 7000}]
cars: [{position_m: [-9, 8.6], heading_deg: 2, length_m: 4.3}]
moving: {people: 9, area_m: [-15, -19, 18, 10]}
)";
constexpr const char* kScanner = R"(scanner:
  step_deg: 0.2
  min_elevation_deg: -60
  max_elevation_deg: 80
  max_range_m: 90
control:
  - {id: P1, position_m: [1, 2, 3], role: check}
crs: {horizontal: EPSG:25832, origin: [691000, 5335800, 500], heading_deg: 30}
)";

std::vector<std::string> Seeds() {
  const std::string stations = kStations;
  return {stations, stations + kObjects, stations + kScanner, stations + kObjects + kScanner};
}

void Read(const std::string& path) { ReadScene(path); }

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &AsItIs}; }

}  // namespace backsight
