#include "pipeline/map_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/octomap_file.h"
#include "io/output_names.h"
#include "pipeline/artifacts/output_units.h"
#include "pipeline/output_files.h"
#include "pipeline/run_outputs.h"
#include "stages/occupancy_map.h"

namespace backsight {
namespace {

/// Float coordinates hold neither a CRS nor a local grid far from its origin.
bool IsInEnu(int component, const OutputSource& source) {
  const auto part = static_cast<std::size_t>(component);
  return source.ground.frame && source.ground.parts[part].placed();
}

std::string Draw(int component, const OutputSource& source, double resolution_m,
                 const ExecutionContext& context) {
  const bool in_enu = IsInEnu(component, source);
  std::vector<PlacedSurface> placed;
  std::vector<MovingLeaves> left_out;
  for (const int member : source.network.parts[static_cast<std::size_t>(component)].stations) {
    const auto s = static_cast<std::size_t>(member);
    const RigidTransform& pose =
        in_enu ? source.ground.enu_from_station[s].value() : source.network.survey_from_station[s];
    placed.push_back(Place(source.stations[s], pose));
    left_out.push_back(source.moving.Of(s));
  }
  OccupancyMapOptions options;
  options.resolution_m = resolution_m;
  options.scale = in_enu ? source.ground.ScaleOf(component) : 1.0;
  const OccupancyMap map = DrawOccupancyMap(placed, left_out, options, context);
  const std::vector<std::uint64_t> keys = map.Keys();
  return OctomapBytes(resolution_m, keys,
                      [&](std::size_t i, OctomapBlock& block) { map.Fill(keys[i], block); });
}

/// Nothing but a warning where the map cannot hold its component.
OutputFiles WriteMap(const std::string& path, int component, const OutputSource& source,
                     double resolution_m, const ExecutionContext& context) {
  std::string bytes;
  try {
    bytes = Draw(component, source, resolution_m, context);
  } catch (const InputError& error) {
    const std::string warning = fmt::format("{} was not written: {}", path, error.what());
    context.Warning(warning);
    return {{}, {warning}};
  }
  WriteTextFile(path, bytes);
  return {{{path, "OctoMap", "", {}}}, {}};
}

/// Maps that lie where this run could have written some, but did not.
void NameStaleMaps(const std::string& path, std::size_t stations, OutputFiles* written) {
  for (int component = 0; component < MostComponents(stations); ++component) {
    const std::string file = ComponentPath(path, component);
    std::error_code error;
    const bool is_new = std::any_of(written->files.begin(), written->files.end(),
                                    [&](const OutputRecord& map) { return map.path == file; });
    if (is_new || !std::filesystem::exists(file, error)) continue;
    written->warnings.push_back(StaleWarning(file));
  }
}

}  // namespace

MapOutput WantedMap(const SurveyProject& project, const std::string& out_directory) {
  MapOutput usual;
  usual.path = (std::filesystem::path(out_directory) / "map.ot").string();
  return project.outputs.map.value_or(usual);
}

ArtifactKey MapKey(const MapOutput& map, int component, ArtifactKey key) {
  key.Add("resolution_m", map.resolution_m);
  key.Add("component", std::to_string(component));
  return key;
}

OutputFiles WriteMaps(const MapOutput& map, const OutputSource& source,
                      const ExecutionContext& context) {
  OutputFiles written;
  if (map.path.empty()) return written;
  MakeDirectories(std::filesystem::path(map.path).parent_path().string());
  const std::size_t components = source.network.parts.size();
  for (std::size_t component = 0; component < components; ++component) {
    context.Progress("map", component, components);
    const std::string path = ComponentPath(map.path, static_cast<int>(component));
    const ArtifactKey key = MapKey(map, static_cast<int>(component), source.key);
    written.Add(WriteOnce(source.store, path, key, context, [&] {
      return WriteMap(path, static_cast<int>(component), source, map.resolution_m, context);
    }));
  }
  context.Progress("map", components, components);
  NameStaleMaps(map.path, source.stations.size(), &written);
  return written;
}

}  // namespace backsight
