#pragma once

#include <memory>
#include <string>

#include "io/scan_reader.h"

namespace backsight {

/// Reads a text cloud: x y z [intensity] [r g b] per line, separated by blanks, tabs, commas or
/// semicolons (the first line of numbers decides). Comments (#, //), blank lines and one header
/// line are allowed. What the columns mean is given, named (ColumnsByNames) or guessed, see
/// GuessXyzLayout, and noted. Columns to skip may hold anything. Memory: constant.
std::unique_ptr<ScanReader> OpenXyz(const std::string& path, const TextColumns& columns = {});

}  // namespace backsight
