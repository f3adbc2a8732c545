#include "pipeline/survey_pipeline.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include "io/run_json.h"
#include "pipeline/cloud_outputs.h"
#include "pipeline/distance_records.h"
#include "pipeline/georeference_network.h"
#include "pipeline/map_output.h"
#include "pipeline/output_files.h"
#include "pipeline/pair_discovery.h"
#include "pipeline/report_pictures.h"
#include "pipeline/run_outputs.h"
#include "pipeline/run_summary.h"
#include "pipeline/symmetry_challenge.h"

namespace backsight {
namespace {

/// Measures the stages; the times go to the manifest only.
class StageClock {
 public:
  explicit StageClock(std::vector<StageTime>* times) : times_(times) {}
  void Finish(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    times_->push_back({stage, std::chrono::duration<double>(now - start_).count()});
    start_ = now;
  }

 private:
  std::vector<StageTime>* times_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

SurveyRun RunSurvey(const SurveyProject& project, const SurveyOptions& options,
                    std::shared_ptr<const GeodeticFrame> frame, const std::string& out_directory,
                    const ExecutionContext& context) {
  SurveyRun run;
  StageClock clock(&run.times);

  const std::vector<Station> stations = LoadStations(project.stations, options, context);
  clock.Finish("stations");

  PairDiscovery discovery = DiscoverPairs(stations, project.pairs, options, context);
  ChallengeSymmetries(stations, options, context, &discovery.pairs);
  clock.Finish("pairs");

  const Network network = BuildNetwork(stations, discovery.pairs, options, context);
  clock.Finish("network");

  const GeoreferencedNetwork ground =
      GeoreferenceNetwork(project, std::move(frame), stations, network, options.georeferencing);
  clock.Finish("georeferencing");

  const MovingPoints moving = FindMovingPoints(stations, network, options.moving_objects, context);
  clock.Finish("moving objects");

  // Poses first: whatever may happen to the large files, they are kept.
  const SurfaceDistances distances = MeasureStationDistances(stations, network, context);
  const std::vector<PictureRecord> pictures =
      DrawReportPictures(stations, network, ground, distances);
  WriteReports(SummarizeRun(project, stations, discovery, network, ground, moving, distances, {}),
               pictures, project.path, out_directory);
  clock.Finish("report");
  const std::vector<WrittenCloud> earlier =
      ReadWrittenClouds((std::filesystem::path(out_directory) / "manifest.json").string());
  const OutputSource source{options.ingest, stations, network, ground, moving};
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
