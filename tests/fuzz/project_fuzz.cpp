#include "io/survey_project.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

// The only file that is there on every machine.
constexpr const char* kStations = R"(schema_version: 1
stations:
  - {id: S1, scan: /proc/self/exe}
  - {id: S2, scan: /proc/self/exe, scan_index: 1, levelled: true, level_sigma_deg: 0.02}
  - id: S3
    scan: /proc/self/exe
    scan_index: 2
    scanner_origin_m: [1, 2, 3]
    prior: {survey_from_station: [0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1], sigma_m: 0.5, sigma_deg: 5}
)";
constexpr const char* kControl = R"(name: "Town hall \u00e4"   # any
crs: {horizontal: EPSG:25832, vertical: EPSG:7837}
control:
  - id: P1
    crs: [691023.412, 5335821.223, 512.034]
    sigma_m: [0.003, 0.003, 0.005]
    role: check
    measured: [{station: S1, xyz: [1.234, 5.678, 0.910]}]
pairs: {include: [[S1, S2]], exclude: [[S2, S3]]}
)";
constexpr const char* kOutputs = R"(registration: {resolution_m: 0.2, solver: second}
outputs:
  merged: [{format: las, path: out/merged.las, thin_m: 0.005, max_points: 500000000}]
gates: {max_station_sigma_mm: 5, max_check_rmse_mm: 10, require_all_stations: true}
resources: {threads: 2, memory_gb: 4}
)";

std::vector<std::string> Seeds() {
  const std::string stations = kStations;
  return {stations, stations + kControl, stations + kOutputs, stations + kControl + kOutputs};
}

void Read(const std::string& path) {
  double resolution_m = 0.1;
  int solver = 0;
  ReadSurveyProject(path, {{"registration", "", [&](OptionVisitor& v) {
                              v.Real("resolution_m", resolution_m, "m", 0.01, 1.0, "");
                              v.Choice("solver", solver, {"first", "second"}, "");
                            }}});
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &AsItIs}; }

}  // namespace backsight
