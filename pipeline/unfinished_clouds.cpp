#include "pipeline/unfinished_clouds.h"

#include <fmt/format.h>

#include <vector>

#include "pipeline/map_output.h"
#include "pipeline/output_files.h"
#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

std::vector<std::string> WantedFiles(const SurveyProject& project,
                                     const std::string& out_directory) {
  std::vector<std::string> files;
  for (const CloudOutput& cloud : MergedOutputs(project, out_directory)) {
    files.push_back(cloud.path);
  }
  if (project.outputs.stations) files.push_back(project.outputs.stations->path);
  const MapOutput map = WantedMap(project, out_directory);
  if (!map.path.empty()) files.push_back(map.path);
  return files;
}

}  // namespace

RunRecord WithUnfinishedClouds(RunRecord run, const SurveyProject& project,
                               const std::string& out_directory) {
  const std::vector<std::string> wanted = WantedFiles(project, out_directory);
  if (wanted.empty() || run.components.empty()) return run;
  run.verdict = "Not finished: clouds and map are still to be written. So far: " + run.verdict;
  if (run.exit_code == kComplete) run.exit_code = kPartial;
  run.warnings.insert(
      run.warnings.begin(),
      fmt::format(
          "{}: still to be written when this report was, or the run ended before; what lies "
          "under these names may be of an earlier run. Poses and links are final. Run again "
          "if no run is under way",
          fmt::join(wanted, ", ")));
  return run;
}

}  // namespace backsight
