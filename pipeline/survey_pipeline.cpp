#include "pipeline/survey_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/free_memory.h"
#include "io/run_json.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/artifacts/network_artifact.h"
#include "pipeline/artifacts/pair_units.h"
#include "pipeline/checked_scanners.h"
#include "pipeline/cloud_outputs.h"
#include "pipeline/distance_records.h"
#include "pipeline/early_pairs.h"
#include "pipeline/georeference_network.h"
#include "pipeline/map_output.h"
#include "pipeline/output_files.h"
#include "pipeline/pair_discovery.h"
#include "pipeline/report_pictures.h"
#include "pipeline/resource_budget.h"
#include "pipeline/run_outputs.h"
#include "pipeline/run_summary.h"
#include "pipeline/stage_clock.h"
#include "pipeline/symmetry_challenge.h"
#include "pipeline/unfinished_clouds.h"

namespace backsight {
namespace {

/// Throws NoRoom where memory is all that keeps the stations from being used.
void RequireMemory(const std::vector<Station>& stations) {
  std::string short_of_memory;
  std::size_t usable = 0;
  for (const Station& station : stations) {
    if (!station.usable() && !station.short_of_memory) return;  // there is more to be told
    if (station.usable()) {
      ++usable;
    } else {
      short_of_memory += (short_of_memory.empty() ? "" : ", ") + station.spec.id;
    }
  }
  if (usable >= 2 || short_of_memory.empty()) return;
  throw NoRoom(fmt::format("stations: each of {} {}", short_of_memory, kShortOfMemory));
}

/// The record of a run that was to end before there is a network.
RunRecord EndedEarly(const std::vector<Station>& stations, Stage last, std::size_t pairs) {
  const auto usable = static_cast<std::size_t>(
      std::count_if(stations.begin(), stations.end(), [](const Station& s) { return s.usable(); }));
  RunRecord record;
  record.exit_code = usable < 2 ? kNoUsableInput : usable < stations.size() ? kPartial : kComplete;
  record.verdict = fmt::format(
      "Ended as asked for (--only {}): {} of {} stations can be used{}.", ToString(last), usable,
      stations.size(),
      last == Stage::kPairs ? fmt::format(", {} pairs were tried", pairs) : std::string());
  return record;
}

}  // namespace

SurveyRun RunSurvey(const SurveyProject& project, const SurveyOptions& options,
                    std::shared_ptr<const GeodeticFrame> frame, const std::string& out_directory,
                    const ExecutionContext& context, const ArtifactStore& store, Stage last) {
  SurveyRun run;
  StageClock clock(context, &run.times);

  std::vector<Station> stations = ListStations(project.stations);
  const PairUnits units(stations, options, context, store, project.resources.pair_limit_s);
  EarlyPairs early(units, project.pairs);
  const auto join_pairs = [&](std::size_t s, WorkQueue* queue) { early.Join(s, queue); };
  LoadStations(options, context, store, last == Stage::kStations ? StationLoaded() : join_pairs,
               &stations);
  for (const Station& station : stations) run.scan_fingerprints.push_back(station.scan.fingerprint);
  RequireMemory(stations);
  clock.Finish("stations");
  if (last == Stage::kStations) {
    run.record = EndedEarly(stations, last, 0);
    return run;
  }

  PairDiscovery discovery =
      DiscoverWithCheckedScanners(units, project.pairs, early.Take(), &stations);
  ChallengeSymmetries(units, &discovery.pairs);
  ForgetPrepared(&stations);  // the stages that follow need none of it
  clock.Finish("pairs");
  if (last == Stage::kPairs) {
    run.record = EndedEarly(stations, last, discovery.pairs.size());
    return run;
  }

  const KeyBase keys{options, context.seed()};
  const ArtifactKey network_key = NetworkKey(keys, stations, discovery.pairs);
  const Network network = Once(store, kNetworkName, network_key, NetworkBytes, NetworkFrom, [&] {
    return BuildNetwork(stations, discovery.pairs, options, context);
  });
  ReturnFreeMemory();
  clock.Finish("network");

  const GeoreferencedNetwork ground =
      GeoreferenceNetwork(project, std::move(frame), stations, network, options.georeferencing);
  clock.Finish("georeferencing");

  const MovingPoints moving =
      Once(store, kMovingName, MovingKey(keys, network_key.Digest()), MovingPointsBytes,
           MovingPointsFrom,
           [&] { return FindMovingPoints(stations, network, options.moving_objects, context); });
  clock.Finish("moving objects");

  // Poses first: whatever may happen to the large files, they are kept. The final reports replace
  // these.
  const SurfaceDistances distances = MeasureStationDistances(stations, network, ground, context);
  const std::vector<PictureRecord> pictures =
      DrawReportPictures(stations, network, ground, distances, context);
  RunRecord unfinished =
      SummarizeRun(project, stations, discovery, network, ground, moving, distances, {});
  if (last == Stage::kNetwork) {
    WriteReports(WithUnfinishedClouds(unfinished, project, out_directory), pictures, project.path,
                 out_directory);
    clock.Finish("report");
    run.record = std::move(unfinished);
    run.record.verdict += " Clouds and map were not asked for.";
    return run;
  }
  WriteReports(WithUnfinishedClouds(unfinished, project, out_directory), pictures, project.path,
               out_directory);
  clock.Finish("report");
  const std::vector<WrittenCloud> earlier =
      ReadWrittenClouds((std::filesystem::path(out_directory) / "manifest.json").string());
  ArtifactKey outputs_key = OutputsKey(keys, project, network_key.Digest());
  AddGround(stations, network, ground, &outputs_key);
  const OutputSource source{options.ingest, stations, network, ground, moving, store, outputs_key};
  const OutputFiles clouds = WriteClouds(project, source, out_directory, context);
  const std::vector<std::string> stale =
      ClearStaleClouds(project, out_directory, earlier, clouds.files, context);
  clock.Finish("merge");
  const OutputFiles maps = WriteMaps(WantedMap(project, out_directory), source, context);
  clock.Finish("map");

  std::vector<OutputRecord> files = clouds.files;
  files.insert(files.end(), maps.files.begin(), maps.files.end());
  run.record =
      SummarizeRun(project, stations, discovery, network, ground, moving, distances, files);
  for (const auto* warnings : {&clouds.warnings, &stale, &maps.warnings}) {
    run.record.warnings.insert(run.record.warnings.end(), warnings->begin(), warnings->end());
  }
  WriteReports(run.record, pictures, project.path, out_directory);
  return run;
}

}  // namespace backsight
