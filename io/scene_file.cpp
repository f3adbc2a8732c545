#include "io/scene_file.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "core/error.h"
#include "io/geodetic_frame.h"
#include "io/scene_objects.h"
#include "io/strict_yaml.h"

namespace backsight {
namespace {

constexpr double kFarthest = 1000.0;

template <typename T>
std::vector<T> ReadList(const YamlValue& root, const std::string& key,
                        T (*read)(const YamlValue&)) {
  std::vector<T> list;
  for (const YamlValue& item : root.Optional(key).Items()) list.push_back(read(item));
  return list;
}

Scanner ReadScanner(const YamlValue& map) {
  Scanner s;
  if (!map.present()) return s;
  s.step_deg = ReadReal(map, "step_deg", s.step_deg, 0.005, 10.0, "deg");
  const YamlValue top = map.Optional("max_elevation_deg");
  s.min_elevation_deg = ReadReal(map, "min_elevation_deg", s.min_elevation_deg, -90, 89, "deg");
  s.max_elevation_deg = top.Real(s.max_elevation_deg, {-89.0, 90.0, "deg"});
  if (s.max_elevation_deg <= s.min_elevation_deg) top.Reject("more than min_elevation_deg");
  const YamlValue far = map.Optional("max_range_m");
  s.min_range_m = ReadReal(map, "min_range_m", s.min_range_m, 0.01, 100.0, "m");
  s.max_range_m = far.Real(s.max_range_m, {1.0, 2000.0, "m"});
  if (s.max_range_m <= s.min_range_m) far.Reject("more than min_range_m");
  s.range_sigma_m = ReadReal(map, "range_sigma_m", s.range_sigma_m, 0.0, 1.0, "m");
  s.range_sigma_ppm = ReadReal(map, "range_sigma_ppm", s.range_sigma_ppm, 0.0, 10000.0, "1e-6");
  s.beam_diameter_m = ReadReal(map, "beam_diameter_m", s.beam_diameter_m, 0.0, 0.1, "m");
  s.beam_divergence_deg =
      ReadReal(map, "beam_divergence_deg", s.beam_divergence_deg, 0.0, 2.0, "deg");
  s.mixed_pixels = map.Optional("mixed_pixels").Flag(s.mixed_pixels);
  s.mixing_m = ReadReal(map, "mixing_m", s.mixing_m, 0.0, 10.0, "m");
  s.dropout = ReadReal(map, "dropout", s.dropout, 0.0, 0.95, "1");
  s.level_sigma_deg = ReadReal(map, "level_sigma_deg", s.level_sigma_deg, 0.0, 10.0, "deg");
  s.orientation = static_cast<Orientation>(
      map.Optional("orientation").Choice(1, {"levelled", "random_heading", "random_so3"}));
  return s;
}

/// Ids name files; `lines` holds the lines of those read so far.
std::string ReadId(const YamlValue& value, std::map<std::string, int>& lines) {
  const std::string id = value.Text();
  if (id.empty()) return id;
  const bool fits =
      id.size() <= 32 && std::all_of(id.begin(), id.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
      });
  if (!fits) value.Reject("at most 32 letters and digits, because it names files");
  const auto [it, inserted] = lines.emplace(id, value.line());
  if (!inserted) {
    value.Reject("an id of its own", "line " + std::to_string(it->second) + " has the same one");
  }
  return id;
}

std::vector<StationSite> ReadStationSites(const YamlValue& list, const Ground& ground) {
  std::vector<StationSite> sites;
  std::map<std::string, int> lines;
  for (const YamlValue& map : list.Items(1, 1000)) {
    StationSite site;
    site.id = ReadId(map.Required("id"), lines);
    const YamlValue position = map.Required("position_m");
    site.position_m = ReadPlanPosition(position);
    if (site.position_m.cwiseAbs().maxCoeff() > 0.5 * ground.size_m) {
      position.Reject("a place on the ground, which is size_m wide about the origin");
    }
    site.height_m = ReadReal(map, "height_m", site.height_m, 0.1, 100.0, "m");
    site.heading_deg = ReadReal(map, "heading_deg", site.heading_deg, -360.0, 360.0, "deg");
    sites.push_back(std::move(site));
  }
  return sites;
}

std::vector<ControlSite> ReadControlSites(const YamlValue& list) {
  std::vector<ControlSite> sites;
  std::map<std::string, int> lines;
  for (const YamlValue& map : list.Items()) {
    ControlSite site;
    site.id = ReadId(map.Required("id"), lines);
    const std::vector<double> v = map.Required("position_m").Reals(3, {-kFarthest, kFarthest, "m"});
    site.position_m = {v[0], v[1], v[2]};
    site.sigma_m = ReadReal(map, "sigma_m", site.sigma_m, 1e-6, 10.0, "m");
    site.measured_sigma_m =
        ReadReal(map, "measured_sigma_m", site.measured_sigma_m, 0.0, 10.0, "m");
    site.check = map.Optional("role").Choice(0, {"control", "check"}) == 1;
    sites.push_back(std::move(site));
  }
  return sites;
}

/// Now, because the project file is written after the scans.
void RejectUnusable(const YamlValue& map, const SceneCrs& crs) {
  std::optional<InputError::Details> fault;
  try {
    GeodeticFrame frame(crs.horizontal, crs.vertical, "");
    fault = frame.FaultOf(crs.origin);
    if (!fault) frame.SetOrigin(crs.origin);
  } catch (const InputError& error) {
    fault = error.details();
  }
  if (fault) map.Reject(fault->expected, fault->remedy, fault->found);
}

SceneCrs ReadSceneCrs(const YamlValue& map) {
  SceneCrs crs;
  crs.horizontal = map.Required("horizontal").Text();
  crs.vertical = map.Optional("vertical").Text();
  constexpr double kEarth = 1e8;
  const std::vector<double> origin = map.Required("origin").Reals(3, {-kEarth, kEarth, "m"});
  crs.origin = {origin[0], origin[1], origin[2]};
  crs.heading_deg = ReadReal(map, "heading_deg", crs.heading_deg, -360.0, 360.0, "deg");
  if (!crs.horizontal.empty() && !crs.origin.isZero(0.0)) RejectUnusable(map, crs);
  return crs;
}

}  // namespace

Scene ReadScene(const std::string& path) {
  YamlDocument document = YamlDocument::Load(path);
  const YamlValue root = document.root();
  root.Required("schema_version").Integer(1, 1, 1);
  Scene scene;
  std::map<std::string, int> names;
  const YamlValue name = root.Optional("name");
  if (name.present()) scene.name = ReadId(name, names);
  scene.seed = static_cast<std::uint64_t>(
      root.Optional("seed").Integer(1, 0, std::numeric_limits<int>::max()));
  scene.format =
      static_cast<CampaignFormat>(root.Optional("format").Choice(0, {"ptx", "ply", "las"}));
  scene.ground = ReadGround(root.Optional("ground"));
  scene.buildings = ReadList(root, "buildings", &ReadBuilding);
  scene.rooms = ReadList(root, "rooms", &ReadRoom);
  scene.barriers = ReadList(root, "barriers", &ReadBarrier);
  scene.poles = ReadList(root, "poles", &ReadPole);
  scene.trees = ReadList(root, "trees", &ReadTree);
  scene.cars = ReadList(root, "cars", &ReadCar);
  const YamlValue moving = root.Optional("moving");
  scene.people = ReadPeople(moving);
  scene.traffic = ReadList(moving, "traffic", &ReadTraffic);
  scene.scanner = ReadScanner(root.Optional("scanner"));
  scene.stations = ReadStationSites(root.Required("stations"), scene.ground);
  scene.control = ReadControlSites(root.Optional("control"));
  const YamlValue crs = root.Optional("crs");
  if (crs.present()) scene.crs = ReadSceneCrs(crs);
  document.ThrowIfInvalid();
  return scene;
}

}  // namespace backsight
