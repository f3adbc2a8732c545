#include "io/survey_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "io/output_names.h"

namespace backsight {
namespace {

/// In the order of CloudFormat.
const std::vector<std::string>& FormatNames() {
  static const std::vector<std::string> names = {"las", "ply", "pcd", "e57"};
  return names;
}

/// NaN where it is absent or wrong, which is reported.
Eigen::Vector3d ReadCorner(const YamlValue& value) {
  Eigen::Vector3d corner = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<YamlValue> items = value.Items(3, 3);
  if (items.size() != 3) return corner;
  for (const int axis : {0, 1, 2}) {
    corner[axis] = items[static_cast<std::size_t>(axis)].Real(corner[axis]);
  }
  return corner;
}

std::optional<CropBox> ReadCrop(const YamlValue& map) {
  if (!map.present()) return std::nullopt;
  const YamlValue max = map.Required("max");
  const CropBox crop{ReadCorner(map.Required("min")), ReadCorner(max)};
  if ((crop.min.array() >= crop.max.array()).any()) {
    max.Reject("three numbers that are greater than those of min");
  }
  return crop;
}

/// The files that no output may be written to, or be read again from, and who has them.
class TakenFiles {
 public:
  explicit TakenFiles(const std::vector<StationSpec>& stations)
      : components_(MostComponents(stations.size())) {
    for (const StationSpec& station : stations) {
      if (!station.scan.empty()) scans_.push_back(station.scan);
    }
  }

  /// What is in the way of a merged cloud; empty if nothing. Remembers it.
  std::string Claim(const CloudOutput& output, int line) {
    std::string obstacle;
    for (const std::string& scan : scans_) {
      if (IsScanOf(output, scan)) obstacle = "the scan " + scan + " is called so";
    }
    for (const auto& [other, other_line] : merged_) {
      if (!MayCollide(output, other, components_)) continue;
      obstacle = fmt::format(
          "line {} may write the same file; components and parts add _component2 and -1 to a name",
          other_line);
    }
    merged_.emplace_back(output, line);
    return obstacle;
  }

  /// True if a scan or a merged cloud may be in the way of `file`.
  bool Contains(const std::string& file) const {
    CloudOutput alone;
    alone.path = file;
    return std::any_of(scans_.begin(), scans_.end(),
                       [&](const std::string& scan) { return IsScanOf(alone, scan); }) ||
           std::any_of(merged_.begin(), merged_.end(), [&](const auto& output) {
             return MayWrite(output.first, components_, file);
           });
  }

 private:
  /// The scan itself, or what a link of that name leads to.
  bool IsScanOf(const CloudOutput& output, const std::string& scan) const {
    std::error_code error;
    const std::string target = std::filesystem::weakly_canonical(scan, error).string();
    return MayWrite(output, components_, scan) || (!error && MayWrite(output, components_, target));
  }

  int components_;
  std::vector<std::string> scans_;
  std::vector<std::pair<CloudOutput, int>> merged_;
};

bool ReadWithoutMoving(const YamlValue& value) { return value.Choice(0, {"mark", "remove"}) == 1; }

CloudOutput ReadMerged(const YamlValue& item, TakenFiles& taken) {
  CloudOutput output;
  const YamlValue format = item.Required("format");
  const int choice = format.Choice(-1, FormatNames());
  const YamlValue path = item.Required("path");
  output.path = path.Path();
  output.thin_m = item.Optional("thin_m").Real(0.0, {0.0, 10.0, "m"});
  const YamlValue max_points = item.Optional("max_points");
  output.max_points = max_points.Integer(0, 0, std::numeric_limits<int>::max());
  output.crop = ReadCrop(item.Optional("crop"));
  output.without_moving = ReadWithoutMoving(item.Optional("moving"));
  if (choice < 0 || output.path.empty()) return output;
  output.format = static_cast<CloudFormat>(choice);
  if (output.max_points > 0 && output.format != CloudFormat::kLas) {
    max_points.Reject("nothing: only LAS files are split");
  }
  const std::string extension = "." + FormatNames()[static_cast<std::size_t>(choice)];
  if (std::filesystem::path(output.path).extension() != extension) {
    path.Reject("a file name ending in " + extension);
  }
  const std::string obstacle = taken.Claim(output, path.line());
  if (!obstacle.empty()) path.Reject("a path that no scan and no other output has", obstacle);
  return output;
}

CloudOutput ReadStationClouds(const YamlValue& map, const std::vector<StationSpec>& stations,
                              const TakenFiles& taken) {
  CloudOutput output;
  output.format = static_cast<CloudFormat>(map.Required("format").Choice(0, FormatNames()));
  output.without_moving = ReadWithoutMoving(map.Optional("moving"));
  const YamlValue path = map.Required("path");
  output.path = path.Path();
  for (const StationSpec& station : stations) {
    const std::string file = StationCloudPath(output, station.id);
    if (output.path.empty() || station.id.empty() || !taken.Contains(file)) continue;
    path.Reject("a folder where no scan or other output is in the way", "choose another folder",
                file);
    break;
  }
  return output;
}

MapOutput ReadMap(const YamlValue& value, const TakenFiles& taken) {
  MapOutput map;
  if (value.IsScalar()) {
    if (value.Text() != "none") value.Reject("none, or a map with path and resolution_m");
    return MapOutput{};
  }
  const YamlValue path = value.Required("path");
  map.path = path.Path();
  map.resolution_m = value.Optional("resolution_m").Real(map.resolution_m, {0.01, 10.0, "m"});
  if (!map.path.empty() && std::filesystem::path(map.path).extension() != ".ot") {
    path.Reject("a file name ending in .ot");
  } else if (taken.Contains(map.path)) {
    path.Reject("a path that no scan and no other output has");
  }
  return map;
}

}  // namespace

OutputSpec ReadOutputs(const YamlValue& node, const std::vector<StationSpec>& stations) {
  OutputSpec outputs;
  TakenFiles taken(stations);
  const YamlValue merged = node.Optional("merged");
  if (merged.present()) {
    outputs.merged.emplace();
    for (const YamlValue& item : merged.Items()) {
      outputs.merged->push_back(ReadMerged(item, taken));
    }
  }
  const YamlValue each = node.Optional("stations");
  if (each.present()) outputs.stations = ReadStationClouds(each, stations, taken);
  const YamlValue map = node.Optional("map");
  if (map.present()) outputs.map = ReadMap(map, taken);
  return outputs;
}

std::string StationCloudPath(const CloudOutput& output, const std::string& station) {
  const std::string& extension = FormatNames()[static_cast<std::size_t>(output.format)];
  return (std::filesystem::path(output.path) / (station + "." + extension)).string();
}

}  // namespace backsight
