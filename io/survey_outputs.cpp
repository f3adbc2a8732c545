#include "io/survey_outputs.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>

namespace backsight {
namespace {

/// In the order of CloudFormat.
const std::vector<std::string>& FormatNames() {
  static const std::vector<std::string> names = {"las", "ply", "pcd", "e57"};
  return names;
}

/// Whether one of the `taken` paths is what a numbered part of `path` could be called.
bool IsPartOf(const std::string& path, const std::set<std::string>& taken) {
  const std::string begin = path.substr(0, path.rfind('.')) + "-";
  return std::any_of(taken.begin(), taken.end(), [&](const std::string& other) {
    return other.starts_with(begin) &&
           other.find_first_not_of("0123456789", begin.size()) == other.rfind('.');
  });
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

CloudOutput ReadMerged(const YamlValue& item, std::set<std::string>& taken) {
  CloudOutput output;
  const YamlValue format = item.Required("format");
  const int choice = format.Choice(-1, FormatNames());
  const YamlValue path = item.Required("path");
  output.path = path.Path();
  output.thin_m = item.Optional("thin_m").Real(0.0, {0.0, 10.0, "m"});
  const YamlValue max_points = item.Optional("max_points");
  output.max_points = max_points.Integer(0, 0, std::numeric_limits<int>::max());
  output.crop = ReadCrop(item.Optional("crop"));
  if (choice < 0 || output.path.empty()) return output;
  output.format = static_cast<CloudFormat>(choice);
  if (output.max_points > 0 && output.format != CloudFormat::kLas) {
    max_points.Reject("nothing: only LAS files are split");
  }
  const std::string extension = "." + FormatNames()[static_cast<std::size_t>(choice)];
  if (std::filesystem::path(output.path).extension() != extension) {
    path.Reject("a file name ending in " + extension);
  }
  if (!taken.insert(output.path).second ||
      (output.max_points > 0 && IsPartOf(output.path, taken))) {
    path.Reject("a path that no scan and no other output has");
  }
  return output;
}

CloudOutput ReadStationClouds(const YamlValue& map, const std::vector<StationSpec>& stations,
                              const std::set<std::string>& taken) {
  CloudOutput output;
  output.format = static_cast<CloudFormat>(map.Required("format").Choice(0, FormatNames()));
  const YamlValue path = map.Required("path");
  output.path = path.Path();
  for (const StationSpec& station : stations) {
    const std::string file = StationCloudPath(output, station.id);
    if (output.path.empty() || station.id.empty() || !taken.contains(file)) continue;
    path.Reject("a folder where no scan or other output is in the way", "choose another folder",
                file);
    break;
  }
  return output;
}

}  // namespace

OutputSpec ReadOutputs(const YamlValue& map, const std::vector<StationSpec>& stations) {
  OutputSpec outputs;
  std::set<std::string> taken;
  for (const StationSpec& station : stations) taken.insert(station.scan);
  const YamlValue merged = map.Optional("merged");
  if (merged.present()) {
    outputs.merged.emplace();
    for (const YamlValue& item : merged.Items()) {
      outputs.merged->push_back(ReadMerged(item, taken));
    }
  }
  const YamlValue each = map.Optional("stations");
  if (each.present()) outputs.stations = ReadStationClouds(each, stations, taken);
  return outputs;
}

std::string StationCloudPath(const CloudOutput& output, const std::string& station) {
  const std::string& extension = FormatNames()[static_cast<std::size_t>(output.format)];
  return (std::filesystem::path(output.path) / (station + "." + extension)).string();
}

}  // namespace backsight
