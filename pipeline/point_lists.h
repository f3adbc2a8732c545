#pragma once

#include <string>

#include "graph/correspondences.h"

namespace backsight {

/// Text file with one correspondence a line: source x y z, target x y z, metres, separated by
/// blanks, tabs or commas; `#` begins a comment line. Equal points share a key point id. Throws
/// InputError with the line.
Correspondences ReadCorrespondences(const std::string& path);

/// Two text files of three columns; row i of one corresponds to row i of the other.
Correspondences ReadMatchedPoints(const std::string& source_path, const std::string& target_path);

}  // namespace backsight
