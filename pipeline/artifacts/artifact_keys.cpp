#include "pipeline/artifacts/artifact_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/archive.h"
#include "core/fingerprint.h"
#include "pipeline/artifacts/program_digest.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, ControlMeasurement& measurement) {
  archive(measurement.station, measurement.xyz_m);
}

template <class Archive>
void Transfer(Archive& archive, ControlPoint& point) {
  archive(point.crs_m, point.sigma_m, point.role, point.measured);
}

namespace {

void AddOptions(const SurveyOptions& options, const std::vector<std::string>& sections,
                ArtifactKey* key) {
  SurveyOptions copy = options;  // visitors may change what they visit
  for (const OptionSection& section : OptionSections(copy)) {
    const bool wanted = std::find(sections.begin(), sections.end(), section.name) != sections.end();
    if (wanted) key->AddLines(CanonicalText(section));
  }
}

std::string ColumnsText(const TextColumns& columns) {
  std::string text;
  for (const TextColumn column : columns) {
    text += (text.empty() ? "" : ",") + TextColumnNames()[static_cast<std::size_t>(column)];
  }
  return text;
}

std::string PriorText(const std::optional<StationPrior>& prior) {
  if (!prior) return "none";
  return fmt::format("{} {:a} {:a}", DigestOf(std::vector{prior->survey_from_station}),
                     prior->sigma_m, prior->sigma_deg);
}

/// What pairs and networks take of a station.
void AddStation(const std::string& role, const Station& station, ArtifactKey* key) {
  const StationSpec& spec = station.spec;
  key->Add(role, station.usable() ? station.digest : "unusable");
  key->Add(role + " levelled",
           spec.levelled ? fmt::format("{:a} deg", spec.level_sigma_deg) : "no");
  key->Add(role + " prior", PriorText(spec.prior));
}

void AddStations(const std::vector<Station>& stations, ArtifactKey* key) {
  for (const Station& station : stations) AddStation("station " + station.spec.id, station, key);
}

}  // namespace

std::string DigestOf(const CropBox& box) {
  return FingerprintText(ToBytes(std::pair(box.min, box.max)));
}

std::string DigestOf(const std::vector<RigidTransform>& motions) {
  return FingerprintText(ToBytes(motions));
}

ArtifactKey StageKey(const KeyBase& base, std::string_view stage,
                     const std::vector<std::string>& sections) {
  ArtifactKey key;
  key.Add("stage", stage);
  key.Add("program", ProgramDigest());
  key.Add("seed", std::to_string(base.seed));
  AddOptions(base.options, sections, &key);
  return key;
}

ArtifactKey StationKey(const KeyBase& base, const StationSpec& spec,
                       const std::string& scan_fingerprint) {
  ArtifactKey key = StageKey(base, "station", {"registration", "features", "matching", "coarse"});
  key.Add("id", spec.id);
  key.Add("scan", scan_fingerprint);
  key.Add("scan_index", std::to_string(spec.scan_index));
  key.Add("columns", ColumnsText(spec.columns));
  key.Add("scanner_origin_m",
          spec.scanner_origin_m ? FingerprintText(ToBytes(*spec.scanner_origin_m)) : "not given");
  return key;
}

ArtifactKey PairKey(const KeyBase& base, std::string_view method, const Station& source,
                    const Station& target, const std::vector<RigidTransform>& motions,
                    const std::string& before) {
  ArtifactKey key = StageKey(base, "pair", {"matching", "coarse", "fine", "verification"});
  key.Add("method", method);
  AddStation("source " + source.spec.id, source, &key);
  AddStation("target " + target.spec.id, target, &key);
  key.Add("motion", DigestOf(motions));
  key.Add("before", before);
  return key;
}

ArtifactKey RankingKey(const KeyBase& base, const std::vector<Station>& stations,
                       const std::vector<char>& may_be_tried) {
  ArtifactKey key = StageKey(base, "ranking", {"pair_selection"});
  AddStations(stations, &key);
  key.Add("may_be_tried", FingerprintText(ToBytes(may_be_tried)));
  return key;
}

ArtifactKey FurtherRankingKey(const KeyBase& base, const std::vector<Station>& stations,
                              const std::vector<std::size_t>& asked) {
  ArtifactKey key = StageKey(base, "further ranking", {"pair_selection"});
  AddStations(stations, &key);
  key.Add("asked", FingerprintText(ToBytes(asked)));
  return key;
}

ArtifactKey ScannersKey(const KeyBase& base, const std::vector<Station>& stations,
                        const PairSpec& spec) {
  ArtifactKey key =
      StageKey(base, "scanners",
               {"matching", "coarse", "fine", "verification", "pair_selection", "network"});
  AddStations(stations, &key);
  for (const auto& [a, b] : spec.include) key.Add("include", a + " " + b);
  for (const auto& [a, b] : spec.exclude) key.Add("exclude", a + " " + b);
  return key;
}

ArtifactKey NetworkKey(const KeyBase& base, const std::vector<Station>& stations,
                       const std::vector<Pair>& pairs) {
  ArtifactKey key =
      StageKey(base, "network", {"verification", "network", "placement_check", "refinement"});
  AddStations(stations, &key);
  for (const Pair& pair : pairs) {
    const auto id = [&](int s) { return stations[static_cast<std::size_t>(s)].spec.id; };
    key.Add(fmt::format("pair {} {}", id(pair.source), id(pair.target)),
            pair.fault.empty() ? pair.digest : "failed");
  }
  return key;
}

ArtifactKey MovingKey(const KeyBase& base, const std::string& network_digest) {
  ArtifactKey key = StageKey(base, "moving", {"moving_objects"});
  key.Add("network", network_digest);
  return key;
}

ArtifactKey OutputsKey(const KeyBase& base, const SurveyProject& project,
                       const std::string& network_digest) {
  ArtifactKey key = StageKey(base, "output", {"georeferencing", "moving_objects"});
  key.Add("network", network_digest);
  key.Add("crs", project.crs ? project.crs->horizontal + " " + project.crs->vertical : "none");
  for (const ControlPoint& point : project.control) {
    key.Add("control " + point.id, FingerprintText(ToBytes(point)));
  }
  return key;
}

void AddGround(const std::vector<Station>& stations, const Network& network,
               const GeoreferencedNetwork& ground, ArtifactKey* key) {
  ArchiveWriter places;
  std::string wkt = ground.frame ? ground.frame->wkt() : "";
  places(wkt);
  for (std::size_t s = 0; s < stations.size(); ++s) {
    std::optional<RigidTransform> pose = ground.enu_from_station[s];
    places(pose);
    if (!pose || network.component[s] < 0) continue;
    double scale = ground.ScaleOf(network.component[s]);
    Eigen::Vector3d low = ground.OutputFromEnu(*pose * stations[s].model.min);
    Eigen::Vector3d high = ground.OutputFromEnu(*pose * stations[s].model.max);
    places(scale, low, high);
  }
  key->Add("ground", FingerprintText(places.Take()));
}

std::string PairArtifactName(const Station& source, const Station& target,
                             std::string_view method) {
  const auto is_unknown = [](const Station& station) {
    return station.model.scanner_place == ScannerPlace::kUnknown;
  };
  return fmt::format("pairs/{}__{}/{}{}", source.spec.id, target.spec.id, method,
                     is_unknown(source) || is_unknown(target) ? "_without_scanner" : "");
}

std::string FileArtifactName(std::string_view folder, const std::string& path) {
  constexpr std::size_t kTold = 8;  // digits
  return fmt::format("{}/{:.100}-{}", folder, std::filesystem::path(path).filename().string(),
                     FingerprintText(path).substr(0, kTold));
}

std::string StationArtifactName(const std::string& station) {
  return "stations/" + station + "/station";
}

}  // namespace backsight
