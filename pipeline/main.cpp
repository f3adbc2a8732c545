#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <map>

#include "core/error.h"
#include "core/free_memory.h"
#include "io/nearest_name.h"
#include "pipeline/artifacts/program_digest.h"
#include "pipeline/commands/commands.h"
#include "pipeline/run_events.h"
#include "pipeline/survey_pipeline.h"
#include "pipeline/version.h"

namespace backsight {
namespace {

void AddFolders(CLI::App* command, RunFolders* folders) {
  command->add_option("project", folders->project, "survey project file (YAML)")->required();
  command->add_option("--out", folders->out, "folder for results (default: out/ beside project)");
  command->add_option("--work", folders->work,
                      "folder for what is finished (default: work/ beside project)");
}

Stage StageOf(const char* option, const std::string& name) {
  for (const Stage stage : kStages) {
    if (ToString(stage) == name) return stage;
  }
  throw CLI::ValidationError(option,
                             "found '" + name + "'; expected stations, pairs, network or outputs");
}

void AddStages(CLI::App* run, RunArguments* arguments) {
  run->add_option_function<std::string>(
         "--from",
         [=](const std::string& name) { arguments->stages.from = StageOf("--from", name); },
         "do this stage and all after it anew: stations, pairs, network or outputs; to go on after "
         "an interruption leave it out")
      ->type_name("STAGE");
  run->add_option_function<std::string>(
         "--only",
         [=](const std::string& name) { arguments->stages.last = StageOf("--only", name); },
         "end after this stage; after network with reports, but without clouds")
      ->type_name("STAGE");
}

void AddSlurm(CLI::App* run, RunArguments* arguments) {
  const std::map<std::string, Executor> executors = {{"local", Executor::kLocal},
                                                     {"slurm", Executor::kSlurm}};
  run->add_option("--executor", arguments->executor,
                  "local: on this machine (default); slurm: as jobs of a cluster")
      ->transform(CLI::CheckedTransformer(executors).description(""))
      ->type_name("local|slurm");
  run->add_option("--slurm-options", arguments->slurm_options,
                  "more options of sbatch for every job, in one quoted text");
  run->add_flag("--wait", arguments->wait, "with slurm: follow the jobs to their end");
  run->add_flag("--force", arguments->force,
                "run although Slurm cannot be asked whether earlier jobs have ended");
  run->add_flag("--final-job", arguments->final_job)->group("");
}

/// What only jobs of a cluster could heed, or they could not, must not be lost silently, nor what
/// takes itself back.
void RequireSense(const RunArguments& arguments) {
  if (arguments.stages.from > arguments.stages.last) {
    throw CLI::ValidationError("--from", "nothing is left of it: --only ends the run before");
  }
  if (arguments.executor == Executor::kSlurm) {
    if (arguments.stages.last == Stage::kOutputs) return;
    throw CLI::ValidationError("--only", "a submission always runs to its end; leave it out");
  }
  if (arguments.wait) throw CLI::ValidationError("--wait", "give it with --executor slurm");
  if (!arguments.slurm_options.empty()) {
    throw CLI::ValidationError("--slurm-options", "give it with --executor slurm");
  }
}

/// Defines a command; `code` receives its exit code when the command line names it.
void AddRun(CLI::App& app, int* code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Register, merge and report a survey project");
  AddFolders(command, &arguments->folders);
  command->add_option("--threads", arguments->threads, "0: all cores")->check(CLI::Range(0, 1024));
  command->add_option("--memory-gb", arguments->memory_gb, "budget of the run (default: project)")
      ->check(CLI::Range(0.25, 65536.0));
  command->add_flag("--dry-run", arguments->dry_run, "only say what would be done, and why");
  command->add_option("--log-json", arguments->log_json,
                      "file for events, one JSON object per line; emptied first");
  CLI::Option* quiet = command->add_flag("--quiet", arguments->quiet, "no progress, only warnings");
  command->add_flag("--verbose", arguments->verbose, "details of every step")->excludes(quiet);
  AddStages(command, arguments.get());
  AddSlurm(command, arguments.get());
  command->callback([=] {
    RequireSense(*arguments);
    *code = RunCommand(*arguments);
  });
}

/// For the jobs of a submission alone.
void AddWork(CLI::App& app, int* code) {
  auto arguments = std::make_shared<WorkArguments>();
  CLI::App* command = app.add_subcommand("work", "Compute a part of a run")->group("");
  AddFolders(command, &arguments->folders);
  command->add_option("--memory-gb", arguments->memory_gb)->check(CLI::Range(0.25, 65536.0));
  CLI::Option* station = command->add_option("--station", arguments->station);
  command->add_option("--shards", arguments->shards)->check(CLI::Range(1, 1'000'000));
  command->add_option("--shard", arguments->shard)
      ->check(CLI::Range(0, 1'000'000))
      ->needs("--shards")
      ->excludes(station);
  command->add_flag("--batch", arguments->batch)->needs("--shards");
  command->add_flag("--coordinate", arguments->coordinate)->excludes(station);
  command->add_option("--done", arguments->done)->needs("--coordinate");
  command->add_option("--threads", arguments->threads)->check(CLI::Range(0, 1024));
  command->add_option("--slurm-options", arguments->slurm_options);
  command->callback([=] { *code = WorkCommand(*arguments); });
}

void AddStatus(CLI::App& app, int* code) {
  auto folders = std::make_shared<RunFolders>();
  CLI::App* command = app.add_subcommand("status", "Say what is done and what is left");
  AddFolders(command, folders.get());
  command->callback([=] { *code = StatusCommand(*folders); });
}

void AddReport(CLI::App& app, int* code) {
  auto folders = std::make_shared<RunFolders>();
  CLI::App* command =
      app.add_subcommand("report", "Write report.html again from the report.json of a run");
  command->add_option("project", folders->project, "survey project file (YAML)")->required();
  command->add_option("--out", folders->out, "folder of results (default: out/ beside project)");
  command->callback([=] { *code = ReportCommand(*folders); });
}

void AddCheck(CLI::App& app, int* code) {
  auto project = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("check", "Validate a project and print the plan");
  command->add_option("project", *project, "survey project file (YAML)")->required();
  command->callback([=] { *code = CheckCommand(*project); });
}

void AddRegister(CLI::App& app, int* code) {
  auto arguments = std::make_shared<RegisterArguments>();
  CLI::App* command = app.add_subcommand(
      "register", "Register one pair: prints target_from_source and its quality");
  CLI::Option* inputs =
      command->add_option("inputs", arguments->inputs, "SOURCE TARGET: two scans")->expected(2);
  CLI::Option* correspondences =
      command->add_option("--correspondences", arguments->correspondences,
                          "file of six columns instead: source x y z, target x y z");
  CLI::Option* matched =
      command->add_flag("--matched", arguments->matched,
                        "SOURCE and TARGET are point lists of three columns; row i matches row i");
  correspondences->excludes(inputs)->excludes(matched);
  command
      ->add_option("--resolution-m", arguments->resolution_m,
                   "edge of the voxels; of point lists: half the accuracy of the points")
      ->check(CLI::Range(0.001, 10.0));
  command->add_option("--threads", arguments->threads, "0: all cores")->check(CLI::Range(0, 1024));
  command->callback([=] {
    if (arguments->correspondences.empty() && arguments->inputs.size() != 2) {
      throw CLI::ValidationError("register", "give SOURCE TARGET or --correspondences FILE");
    }
    *code = RegisterCommand(*arguments);
  });
}

void AddEvaluate(CLI::App& app, int* code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command = app.add_subcommand("evaluate", "Compare poses with ground truth");
  command->add_option("poses", arguments->poses, "poses.csv of a run, or its output folder")
      ->required();
  command
      ->add_option("--truth", arguments->truth,
                   "CSV like poses.csv, folder of a simulated campaign or of gt_pose<i>.txt, or "
                   "3DMatch gt.log")
      ->required();
  command->add_option("--re", arguments->max_re_deg, "largest rotation error of a success, deg")
      ->capture_default_str();
  command->add_option("--te", arguments->max_te_m, "largest translation error of a success, m")
      ->capture_default_str();
  command->callback([=] { *code = EvaluateCommand(*arguments); });
}

void AddInfo(CLI::App& app, int* code) {
  auto scan = std::make_shared<std::string>();
  auto index = std::make_shared<int>(0);
  auto columns = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("info", "Say what a scan file holds");
  command->add_option("scan", *scan, "scan file")->required();
  command->add_option("--scan-index", *index, "which scan of the file, from 0");
  command->add_option("--columns", *columns,
                      "of a text scan: x,y,z,intensity,r,g,b,skip in its order; default: guessed");
  command->callback([=] { *code = InfoCommand(*scan, *index, *columns); });
}

void AddOptions(CLI::App& app, int* code) {
  auto markdown = std::make_shared<bool>(false);
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("options", "List every option with its default");
  CLI::Option* flag = command->add_flag("--markdown", *markdown, "as docs/options.md");
  command->add_flag("--json", *json, "as JSON")->excludes(flag);
  command->callback([=] {
    *code = OptionsCommand(*markdown ? OptionsFormat::kMarkdown
                           : *json   ? OptionsFormat::kJson
                                     : OptionsFormat::kText);
  });
}

void AddSimulate(CLI::App& app, int* code) {
  auto scene = std::make_shared<std::string>();
  auto directory = std::make_shared<std::string>();
  auto threads = std::make_shared<int>(0);
  CLI::App* command = app.add_subcommand("simulate", "Make a campaign with exact truth");
  command->add_option("scene", *scene, "scene file (YAML)")->required();
  command->add_option("directory", *directory, "where to write it")->required();
  command->add_option("--threads", *threads, "0: all cores")->check(CLI::Range(0, 1024));
  command->callback([=] { *code = SimulateCommand(*scene, *directory, *threads); });
}

void AddDemo(CLI::App& app, int* code) {
  auto directory = std::make_shared<std::string>("backsight-demo");
  auto threads = std::make_shared<int>(0);
  CLI::App* command = app.add_subcommand("demo", "Simulate a small campaign and run it");
  command->add_option("directory", *directory, "where to write it");
  command->add_option("--threads", *threads, "0: all cores")->check(CLI::Range(0, 1024));
  command->callback([=] { *code = DemoCommand(*directory, *threads); });
}

/// The parser would only say that the word was not expected.
void RequireKnownCommand(const CLI::App& app, const std::string& word) {
  if (word.empty() || word.front() == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  if (std::find(names.begin(), names.end(), word) != names.end()) return;
  const std::string nearest = NearestName(word, names);
  throw InputError({"command line", "an unknown command, '" + word + "'",
                    fmt::format("one of: {}", fmt::join(names, ", ")),
                    nearest.empty() ? "" : "did you mean '" + nearest + "'?"});
}

int Main(int argc, char** argv) {
  ProgramDigest();  // of the libraries the program starts with
  CLI::App app("Backsight: terrestrial laser scans to one registered point cloud");
  app.set_version_flag("--version", std::string("backsight ") + kVersion);
  app.require_subcommand(1);
  int code = kComplete;
  for (const auto add : {AddRun, AddWork, AddStatus, AddReport, AddCheck, AddRegister, AddEvaluate,
                         AddInfo, AddOptions, AddSimulate, AddDemo}) {
    add(app, &code);
  }
  if (argc > 1) RequireKnownCommand(app, argv[1]);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kComplete : kBadInput;
  }
  return code;
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  backsight::ReturnLargeBlocksAtOnce();
  try {
    return backsight::Main(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return backsight::ExitCodeOf(error);
  }
}
