#include "io/survey_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "core/error.h"
#include "io/option_reader.h"
#include "io/strict_yaml.h"
#include "io/survey_outputs.h"
#include "io/survey_stations.h"

namespace backsight {
namespace {

using IdPair = std::pair<std::string, std::string>;

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
  resources.pair_limit_s =
      map.Optional("pair_limit_s").Real(resources.pair_limit_s, {0.0, 1e6, "s"});
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

/// Every place was read before, so that going there again adds no violation.
void RejectPlace(const YamlValue& crs, const YamlValue& control, const ProjectFault& fault) {
  using Place = ProjectFault::Place;
  YamlValue place = fault.place == Place::kCrs ? crs : control;
  if (fault.place == Place::kPoint || fault.place == Place::kSighting) {
    place = control.Items().at(fault.point);
  }
  if (fault.place == Place::kPoint) place = place.Required("crs");
  if (fault.place == Place::kSighting) {
    place = place.Required("measured").Items(1).at(fault.sighting).Required("xyz");
  }
  place.Reject(fault.expected, fault.remedy, fault.found);
}

}  // namespace

SurveyProject ReadSurveyProject(const std::string& path, const std::vector<OptionSection>& sections,
                                const ProjectCheck& check) {
  CheckSectionNames(sections);
  YamlDocument document = YamlDocument::Load(path);
  const YamlValue root = document.root();
  SurveyProject project;
  project.path = path;
  ReadSchemaVersion(root.Required("schema_version"));
  project.name = root.Optional("name").Text(std::filesystem::path(path).stem().string());
  WholeParts whole;
  // The keys of the map itself must be known before, or asking for them takes violations back.
  const auto read = [&](const auto& part) {
    const std::size_t before = document.Violations().size();
    part();
    return document.Violations().size() == before;
  };
  const YamlValue crs = root.Optional("crs");
  const YamlValue stations = root.Required("stations");
  const YamlValue control = root.Optional("control");
  whole.crs = read([&] {
    if (crs.present()) project.crs = ReadCrs(crs);
  });
  whole.stations = read([&] { project.stations = ReadStations(stations); });
  whole.control = read([&] { project.control = ReadControl(control, project.stations); });
  project.pairs = ReadPairs(root.Optional("pairs"), project.stations);
  project.outputs = ReadOutputs(root.Optional("outputs"), project.stations);
  project.gates = ReadGates(root.Optional("gates"));
  project.resources = ReadResources(root.Optional("resources"));
  ReadOptions(root, sections);
  if (check) {
    for (const ProjectFault& fault : check(project, whole)) RejectPlace(crs, control, fault);
  }
  document.ThrowIfInvalid();
  return project;
}

}  // namespace backsight
