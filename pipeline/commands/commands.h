#pragma once

#include <string>
#include <vector>

namespace backsight {

/// The commands of the program. Each returns the exit code; faulty input throws InputError. Results
/// go to stdout, progress and warnings to stderr.

struct RunArguments {
  std::string project;
  std::string out;   ///< empty: out/ beside the project file
  int threads = -1;  ///< -1: as the project file says; 0: all cores
  bool quiet = false;
  bool verbose = false;
};
int RunCommand(const RunArguments& arguments);

/// `out`: the folder of results; empty: out/ beside the project file.
int ReportCommand(const std::string& project, const std::string& out);

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
int EvaluateCommand(const EvaluateArguments& arguments);

/// `columns`: of a text scan, "x,y,z,skip"; empty: guessed.
int InfoCommand(const std::string& scan, int scan_index, const std::string& columns);

enum class OptionsFormat { kText, kMarkdown, kJson };
int OptionsCommand(OptionsFormat format);

int SimulateCommand(const std::string& scene, const std::string& directory, int threads);

int DemoCommand(const std::string& directory, int threads);

}  // namespace backsight
