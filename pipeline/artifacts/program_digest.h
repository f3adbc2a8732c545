#pragma once

#include <string>

namespace backsight {

/// Fingerprint of the program that runs and of the libraries it was started with, so that no result
/// outlives the code that made it.
const std::string& ProgramDigest();

}  // namespace backsight
