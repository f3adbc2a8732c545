#include "pipeline/e57_scans.h"

#include <fmt/format.h>

#include <bit>
#include <set>

#include "core/fingerprint.h"
#include "io/topocentric_wkt.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

void Add(double value, Fingerprint* fingerprint) {
  fingerprint->Add(std::bit_cast<std::uint64_t>(value));
}

void Add(const Eigen::Vector3d& values, Fingerprint* fingerprint) {
  for (const double value : values) Add(value, fingerprint);
}

/// A UUID of version 8 (RFC 9562): its bits are a hash of our own.
std::string GuidOf(const Fingerprint& fingerprint) {
  std::string hex = fingerprint.Hex();
  hex[12] = '8';
  hex[16] = "89ab"[fingerprint.Value64() % 4];
  return fmt::format("{{{}-{}-{}-{}-{}}}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                     hex.substr(16, 4), hex.substr(20));
}

/// What is left out of an output, on which the points of its scans depend.
void AddSelection(const CloudOutput& output, bool without_moving, Fingerprint* fingerprint) {
  Add(output.thin_m, fingerprint);
  if (without_moving) fingerprint->Add("without moving");
  if (output.crop) {
    Add(output.crop->min, fingerprint);
    Add(output.crop->max, fingerprint);
  }
}

std::string DerivedGuid(const Station& station, const CloudOutput& output, bool without_moving) {
  Fingerprint fingerprint;
  fingerprint.Add("scan");
  fingerprint.Add(station.spec.id);
  fingerprint.Add(station.content_fingerprint);
  AddSelection(output, without_moving, &fingerprint);
  return GuidOf(fingerprint);
}

}  // namespace

std::map<int, E57ScanSpec> E57ScansOf(const std::vector<int>& stations, const OutputSource& source,
                                      const CloudOutput& output) {
  std::map<int, E57ScanSpec> scans;
  std::set<std::string> guids;
  for (const int index : stations) {
    const auto s = static_cast<std::size_t>(index);
    const Station& station = source.stations[s];
    E57ScanSpec& scan = scans[index + 1];
    const bool without_moving = output.without_moving && source.moving.Of(s).points > 0;
    const std::string derived = DerivedGuid(station, output, without_moving);
    scan.guid = station.info.guid.empty() ? derived : station.info.guid;
    if (!guids.insert(scan.guid).second) {
      scan.guid = derived;
      guids.insert(scan.guid);
    }
    scan.name = station.info.name.empty() ? station.spec.id : station.info.name;
    scan.world_from_scan =
        source.ground.enu_from_station[s].value_or(source.network.survey_from_station[s]);
    scan.has_intensity = station.info.has_intensity;
    scan.has_rgb = station.info.has_rgb;
    scan.rgb_16_bit = station.info.rgb_16_bit;
    scan.rows = station.info.rows;
    scan.columns = station.info.columns;
  }
  return scans;
}

E57FileSpec E57FileOf(const CloudOutput& output, const std::map<int, E57ScanSpec>& scans,
                      const GeodeticFrame* frame) {
  E57FileSpec file;
  file.path = output.path;
  file.generator = fmt::format("backsight {}", kVersion);
  if (frame != nullptr) file.crs = TopocentricWkt(frame->name(), frame->origin());
  Fingerprint fingerprint;
  fingerprint.Add("file");
  fingerprint.Add(file.crs);
  AddSelection(output, output.without_moving, &fingerprint);
  for (const auto& [number, scan] : scans) {
    fingerprint.Add(scan.guid);
    for (int column = 0; column < 3; ++column) {
      Add(Eigen::Vector3d(scan.world_from_scan.rotation.col(column)), &fingerprint);
    }
    Add(scan.world_from_scan.translation, &fingerprint);
  }
  file.guid = GuidOf(fingerprint);
  return file;
}

}  // namespace backsight
