#pragma once

#include <string>
#include <vector>

namespace backsight {

/// The user's options of sbatch for every job of a run, as words. Throws InputError that names
/// --slurm-options where SplitWords does, and where one of them is an option that the run itself
/// relies on, also abbreviated or in a bundle of letters as sbatch would take it: the user's
/// options come last, and so would win.
std::vector<std::string> SbatchOptions(const std::string& text);

}  // namespace backsight
