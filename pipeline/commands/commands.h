#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/run_stages.h"

namespace backsight {

/// The commands of the program. Each returns the exit code; faulty input throws InputError. Results
/// go to stdout, progress and warnings to stderr.

/// A project and where its results go and its finished work is kept.
struct RunFolders {
  std::string project;
  std::string out;   ///< empty: out/ beside the project file
  std::string work;  ///< empty: work/ beside the project file

  std::string OutDirectory() const;
  std::string WorkDirectory() const;
};

enum class Executor { kLocal, kSlurm };

struct RunArguments {
  RunFolders folders;
  std::string log_json;             ///< event log, empty for none
  int threads = -1;                 ///< -1: as the project file says; 0: all cores
  std::optional<double> memory_gb;  ///< absent: as the project file says
  bool quiet = false;
  bool verbose = false;
  bool dry_run = false;  ///< only say what would be done, and why
  StageRange stages;
  Executor executor = Executor::kLocal;
  std::string slurm_options;  ///< more options of sbatch, as in a shell
  bool wait = false;          ///< follow the jobs to their end
  bool force = false;         ///< also where Slurm cannot be asked whether earlier jobs go on
  bool final_job = false;     ///< this is the last job of a submission
};
int RunCommand(const RunArguments& arguments);

/// A part of a run on a cluster, stored in the work folder: a station, a shard of the pairs, or
/// what is to be done next.
struct WorkArguments {
  RunFolders folders;
  std::optional<double> memory_gb;  ///< absent: as the project file says
  int station = -1;                 ///< its index in the project
  int shard = 0;                    ///< of `shards`
  int shards = 0;                   ///< 0: no pairs are wanted
  bool batch = false;               ///< the pairs are those of the stored batch
  bool coordinate = false;          ///< have the next pairs registered by other jobs
  std::optional<std::size_t> done;  ///< attempts that were stored when the last ones began
  int threads = 0;                  ///< of the jobs that a coordinator submits
  std::string slurm_options;        ///< of these
};
int WorkCommand(const WorkArguments& arguments);

/// What a run would do and why; it does nothing.
int PrintDryRun(const RunFolders& folders, const StageRange& stages);

/// What is done, what is left, and the run that is going.
int StatusCommand(const RunFolders& folders);

/// Writes the page of the last run's report again.
int ReportCommand(const RunFolders& folders);

int CheckCommand(const std::string& project);

struct RegisterArguments {
  std::vector<std::string> inputs;  ///< SOURCE TARGET: scans, or with `matched` point lists
  std::string correspondences;      ///< six-column file instead of inputs
  bool matched = false;             ///< row i of SOURCE corresponds to row i of TARGET
  double resolution_m = 0.0;        ///< 0: the default of the options
  int threads = 0;
};
int RegisterCommand(const RegisterArguments& arguments);

struct EvaluateArguments {
  std::string poses;
  std::string truth;
  double max_re_deg = 5.0;
  double max_te_m = 0.5;
};
int EvaluateCommand(EvaluateArguments arguments);

/// `columns`: of a text scan, "x,y,z,skip"; empty: guessed.
int InfoCommand(const std::string& scan, int scan_index, const std::string& columns);

enum class OptionsFormat { kText, kMarkdown, kJson };
int OptionsCommand(OptionsFormat format);

int SimulateCommand(const std::string& scene, const std::string& directory, int threads);

int DemoCommand(const std::string& directory, int threads);

}  // namespace backsight
