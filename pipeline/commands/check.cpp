#include <fmt/format.h>

#include "core/error.h"
#include "io/scan_reader.h"
#include "pipeline/commands/commands.h"
#include "pipeline/georeference_network.h"
#include "pipeline/output_files.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {

int CheckCommand(const std::string& project_path) {
  SurveyOptions options;
  const SurveyProject project = ReadSurveyProject(project_path, OptionSections(options));
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
  fmt::print(", {} merged cloud(s)\n",
             project.outputs.merged ? project.outputs.merged->size() : std::size_t{1});
  if (faults == 0) return kComplete;
  fmt::print("{} of {} scans cannot be used\n", faults, project.stations.size());
  return static_cast<int>(project.stations.size()) - faults < 2 ? kNoUsableInput : kPartial;
}

}  // namespace backsight
