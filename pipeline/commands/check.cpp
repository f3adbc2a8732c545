#include <fmt/format.h>

#include "core/error.h"
#include "io/scan_reader.h"
#include "pipeline/checked_project.h"
#include "pipeline/commands/commands.h"
#include "pipeline/control_frame.h"
#include "pipeline/map_output.h"
#include "pipeline/output_files.h"
#include "pipeline/resource_budget.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/terminal_events.h"

namespace backsight {

namespace {

void PrintOutputs(const SurveyProject& project, const std::string& out_directory) {
  for (const CloudOutput& cloud : MergedOutputs(project, out_directory)) {
    std::string how;
    if (cloud.thin_m > 0.0) how += fmt::format(", thinned to {:g} m", cloud.thin_m);
    if (cloud.max_points > 0) how += fmt::format(", {} points per file", cloud.max_points);
    if (cloud.crop) how += ", cropped";
    if (cloud.without_moving) how += ", without what moved";
    fmt::print("output: merged cloud {}{}\n", cloud.path, how);
  }
  if (const auto& clouds = project.outputs.stations) {
    fmt::print("output: a cloud per station, {} and so on{}\n",
               StationCloudPath(*clouds, project.stations.front().id),
               clouds->without_moving ? ", without what moved" : "");
  }
  const MapOutput map = WantedMap(project, out_directory);
  if (!map.path.empty()) {
    fmt::print("output: map {}, voxels of {:g} m\n", map.path, map.resolution_m);
  }
  fmt::print("output: tables and report in {}\n", out_directory);
}

void PrintGates(const GateSpec& gates) {
  if (gates.max_station_sigma_mm) {
    fmt::print("gate: max_station_sigma_mm {:g}\n", *gates.max_station_sigma_mm);
  }
  if (gates.max_check_rmse_mm) {
    fmt::print("gate: max_check_rmse_mm {:g}\n", *gates.max_check_rmse_mm);
  }
  if (gates.require_all_stations) fmt::print("gate: require_all_stations\n");
}

/// Throws NoRoom where a run could not end well.
void RequireRoomForRun(const SurveyProject& project) {
  TerminalEvents events(TerminalEvents::Verbosity::kQuiet);
  const ExecutionContext context(1, kRunSeed, &events);
  const ArtifactStore store(UsualWorkDirectory(project.path));
  RequireRoom(EstimateNeeds(project, UsualOutDirectory(project.path), store),
              project.resources.memory_gb, context);
}

}  // namespace

int CheckCommand(const std::string& project_path) {
  SurveyOptions options;
  const SurveyProject project = ReadCheckedProject(project_path, &options);
  const auto frame = MakeControlFrame(project);
  RequireFreeNames(project, UsualOutDirectory(project_path));

  int faults = 0;
  std::vector<Station> stations;
  fmt::print("{}: {} stations\n", project.name, project.stations.size());
  for (const StationSpec& spec : project.stations) {
    Station& station = stations.emplace_back();
    station.spec = spec;
    try {
      const ScanInfo info = OpenScan(spec.scan, spec.scan_index, spec.columns)->info();
      const std::string points =
          info.point_count ? fmt::format("{} points", *info.point_count) : "points not declared";
      fmt::print("  {:<12} {:<5} {:>20}  {}\n", spec.id, info.format, points, spec.scan);
    } catch (const InputError& error) {
      station.fault = error.what();
      ++faults;
      fmt::print("  {:<12} unusable: {}\n", spec.id, error.what());
    }
  }
  const auto usable = static_cast<int>(stations.size()) - faults;
  if (!project.control.empty()) {
    fmt::print("  {} survey points in {}\n", project.control.size(),
               frame ? frame->name() + ", " + frame->heights() : "a local grid");
  }
  fmt::print("plan: {} pairs{} at {:g} m resolution", PlanPairs(stations, project.pairs).size(),
             IsExhaustive(usable, options.pair_selection) ? "" : ", the promising ones of them,",
             options.ingest.resolution_m);
  fmt::print("\n");
  PrintOutputs(project, UsualOutDirectory(project_path));
  PrintGates(project.gates);
  RequireRoomForRun(project);
  if (faults == 0) return kComplete;
  fmt::print("{} of {} scans cannot be used\n", faults, project.stations.size());
  return static_cast<int>(project.stations.size()) - faults < 2 ? kNoUsableInput : kPartial;
}

}  // namespace backsight
