#include "io/survey_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "core/error.h"
#include "io/option_reader.h"
#include "io/strict_yaml.h"
#include "io/survey_stations.h"

namespace backsight {
namespace {

using IdPair = std::pair<std::string, std::string>;

/// In the order of CloudFormat.
const std::vector<std::string>& FormatNames() {
  static const std::vector<std::string> names = {"las", "ply", "pcd", "e57"};
  return names;
}

void ReadSchemaVersion(const YamlValue& value) {
  if (!value.present()) return;
  if (value.Integer(0, 0, 1000000) != 1) value.Reject("1, the version that this program reads");
}

/// "EPSG:25832": an authority and a code. Whether PROJ knows it is found out when it is used.
std::string ReadCrsName(const YamlValue& value) {
  const std::string name = value.Text();
  const std::size_t colon = name.find(':');
  const bool formed = colon != std::string::npos && colon > 0 && colon + 1 < name.size() &&
                      name.find_first_of(" \t") == std::string::npos;
  if (!name.empty() && !formed) value.Reject("authority and code, like EPSG:25832");
  return name;
}

CrsSpec ReadCrs(const YamlValue& map) {
  CrsSpec crs;
  crs.horizontal = ReadCrsName(map.Required("horizontal"));
  const YamlValue vertical = map.Optional("vertical");
  if (vertical.present()) crs.vertical = ReadCrsName(vertical);
  return crs;
}

IdPair Sorted(const IdPair& pair) { return std::minmax(pair.first, pair.second); }

/// `listed` maps the pairs seen so far in either list to their lines.
std::vector<IdPair> ReadPairList(const YamlValue& list, const std::vector<StationSpec>& stations,
                                 std::map<IdPair, int>& listed) {
  std::vector<IdPair> pairs;
  for (const YamlValue& item : list.Items()) {
    const std::vector<YamlValue> ends = item.Items(2, 2);
    if (ends.size() != 2) continue;
    const IdPair pair{ends[0].Text(), ends[1].Text()};
    RequireStation(ends[0], pair.first, stations);
    RequireStation(ends[1], pair.second, stations);
    if (pair.first.empty() || pair.second.empty()) continue;
    const std::string found = fmt::format("[{}, {}]", pair.first, pair.second);
    if (pair.first == pair.second) {
      item.Reject("two different stations", "", found);
      continue;
    }
    const auto [it, inserted] = listed.emplace(Sorted(pair), item.line());
    if (!inserted) {
      item.Reject("each pair once in include and exclude together",
                  fmt::format("line {} has the same pair", it->second), found);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

PairSpec ReadPairs(const YamlValue& value, const std::vector<StationSpec>& stations) {
  PairSpec pairs;
  if (!value.present()) return pairs;
  if (!value.IsMap()) {
    const std::string expected = "auto, or a map with include and exclude";
    if (!value.IsScalar() || value.Text() != "auto") value.Reject(expected);
    return pairs;
  }
  std::map<IdPair, int> listed;
  pairs.include = ReadPairList(value.Optional("include"), stations, listed);
  pairs.exclude = ReadPairList(value.Optional("exclude"), stations, listed);
  return pairs;
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

GateSpec ReadGates(const YamlValue& map) {
  constexpr RealRange range{1e-3, 1e6, "mm"};
  GateSpec gates;
  const YamlValue sigma = map.Optional("max_station_sigma_mm");
  if (sigma.present()) gates.max_station_sigma_mm = sigma.Real(1.0, range);
  const YamlValue rmse = map.Optional("max_check_rmse_mm");
  if (rmse.present()) gates.max_check_rmse_mm = rmse.Real(1.0, range);
  gates.require_all_stations = map.Optional("require_all_stations").Flag(false);
  return gates;
}

ResourceSpec ReadResources(const YamlValue& map) {
  ResourceSpec resources;
  resources.threads = map.Optional("threads").Integer(resources.threads, 0, 4096);
  resources.memory_gb = map.Optional("memory_gb").Real(resources.memory_gb, {0.25, 65536.0, "GB"});
  return resources;
}

void CheckSectionNames(const std::vector<OptionSection>& sections) {
  constexpr std::array<std::string_view, 9> kOwn = {"schema_version", "name",    "crs",
                                                    "stations",       "control", "pairs",
                                                    "outputs",        "gates",   "resources"};
  for (const OptionSection& section : sections) {
    BACKSIGHT_CHECK(std::find(kOwn.begin(), kOwn.end(), section.name) == kOwn.end(),
                    "option section '" + section.name + "' has the name of a project key");
  }
}

}  // namespace

SurveyProject ReadSurveyProject(const std::string& path,
                                const std::vector<OptionSection>& sections) {
  CheckSectionNames(sections);
  YamlDocument document = YamlDocument::Load(path);
  const YamlValue root = document.root();
  SurveyProject project;
  project.path = path;
  ReadSchemaVersion(root.Required("schema_version"));
  project.name = root.Optional("name").Text(std::filesystem::path(path).stem().string());
  const YamlValue crs = root.Optional("crs");
  if (crs.present()) project.crs = ReadCrs(crs);
  project.stations = ReadStations(root.Required("stations"));
  project.control = ReadControl(root.Optional("control"), project.stations);
  project.pairs = ReadPairs(root.Optional("pairs"), project.stations);
  project.outputs = ReadOutputs(root.Optional("outputs"), project.stations);
  project.gates = ReadGates(root.Optional("gates"));
  project.resources = ReadResources(root.Optional("resources"));
  ReadOptions(root, sections);
  document.ThrowIfInvalid();
  return project;
}

std::string StationCloudPath(const CloudOutput& output, const std::string& station) {
  const std::string& extension = FormatNames()[static_cast<std::size_t>(output.format)];
  return (std::filesystem::path(output.path) / (station + "." + extension)).string();
}

}  // namespace backsight
