#include "pipeline/map_output.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/output_names.h"
#include "pipeline/run_outputs.h"
#include "stages/occupancy_map.h"

namespace backsight {
namespace {

std::string Draw(int component, const MapSource& source, double resolution_m,
                 const ExecutionContext& context) {
  std::vector<PlacedSurface> placed;
  std::vector<MovingLeaves> left_out;
  for (std::size_t s = 0; s < source.stations.size(); ++s) {
    if (source.network.component[s] != component) continue;
    placed.push_back(Place(source.stations[s], source.ground.enu_from_station[s].value_or(
                                                   source.network.survey_from_station[s])));
    left_out.push_back(source.moving.stations[s]);
  }
  return DrawOccupancyMap(placed, left_out, resolution_m, context);
}

}  // namespace

MapOutput WantedMap(const SurveyProject& project, const std::string& out_directory) {
  MapOutput usual;
  usual.path = (std::filesystem::path(out_directory) / "map.ot").string();
  return project.outputs.map.value_or(usual);
}

MapFiles WriteMaps(const MapOutput& map, const MapSource& source, const ExecutionContext& context) {
  MapFiles written;
  if (map.path.empty()) return written;
  MakeDirectories(std::filesystem::path(map.path).parent_path().string());
  const std::size_t components = source.network.parts.size();
  for (std::size_t component = 0; component < components; ++component) {
    context.Progress("map", component, components);
    const std::string path = ComponentPath(map.path, static_cast<int>(component));
    std::string bytes;
    try {
      bytes = Draw(static_cast<int>(component), source, map.resolution_m, context);
    } catch (const InputError& error) {
      written.warnings.push_back(fmt::format("{} was not written: {}", path, error.what()));
      context.Warning(written.warnings.back());
      continue;
    }
    WriteTextFile(path, bytes);
    written.files.push_back({path, "OctoMap", {}});
  }
  context.Progress("map", components, components);
  return written;
}

}  // namespace backsight
