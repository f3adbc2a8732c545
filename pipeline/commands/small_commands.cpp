#include <fmt/format.h>

#include <filesystem>

#include "io/atomic_file.h"
#include "io/option_table.h"
#include "io/scan_description.h"
#include "io/scan_reader.h"
#include "pipeline/commands/commands.h"
#include "pipeline/demo_scene.h"
#include "pipeline/heartbeat.h"
#include "pipeline/run_outputs.h"
#include "pipeline/simulate_campaign.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/terminal_events.h"

namespace backsight {

int InfoCommand(const std::string& scan, int scan_index, const std::string& columns) {
  const TextColumns given =
      columns.empty() ? TextColumns{} : ParseTextColumns(columns, "--columns");
  fmt::print("{}", DescribeScan(OpenScan(scan, scan_index, given)->info()));
  return kComplete;
}

int OptionsCommand(OptionsFormat format) {
  SurveyOptions options;
  const std::vector<OptionSection> sections = OptionSections(options);
  switch (format) {
    case OptionsFormat::kText:
      fmt::print("{}", OptionsAsText(sections));
      break;
    case OptionsFormat::kMarkdown:
      fmt::print("{}", OptionsAsMarkdown(sections));
      break;
    case OptionsFormat::kJson:
      fmt::print("{}\n", OptionsAsJson(sections));
      break;
  }
  return kComplete;
}

int SimulateCommand(const std::string& scene, const std::string& directory, int threads) {
  TerminalEvents events(TerminalEvents::Verbosity::kNormal);
  const Heartbeat heartbeat([&events] { events.Tick(); });
  SimulateCampaign(scene, directory, ExecutionContext(threads, /*seed=*/0, &events));
  fmt::print("campaign written to {}\n", directory);
  return kComplete;
}

int DemoCommand(const std::string& directory, int threads) {
  namespace fs = std::filesystem;
  MakeDirectories(directory);
  const std::string scene = (fs::path(directory) / "scene.yaml").string();
  WriteTextFile(scene, kDemoScene);
  SimulateCommand(scene, directory, threads);
  RunArguments run;
  run.folders.project = (fs::path(directory) / "demo.yaml").string();
  run.threads = threads;
  const int exit_code = RunCommand(run);
  if (exit_code == kInterrupted || exit_code == kTerminated) return exit_code;
  EvaluateCommand({.poses = (fs::path(directory) / "out" / "poses.csv").string(),
                   .truth = (fs::path(directory) / "truth.csv").string()});
  fmt::print("\nOpen the report: {}\n",
             fs::absolute(fs::path(directory) / "out" / "report.html").string());
  return exit_code;
}

}  // namespace backsight
