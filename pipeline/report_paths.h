#pragma once

#include <string>

#include "io/run_records.h"

namespace backsight {

/// The record with the paths of scans and outputs, also within reasons, notes and warnings, as seen
/// from the folder of the project file where they lie under it, and absolute elsewhere: results do
/// not depend on where the project lies, nor on the folder that the program was started in.
RunRecord WithProjectPaths(RunRecord run, const std::string& project_path);

}  // namespace backsight
