#pragma once

#include <string>

namespace backsight {

/// Fingerprint of the program that runs and of the libraries loaded at the first call, so that no
/// result outlives the code that made it; the kernel does not count. To be called first before
/// there are threads: oneTBB loads more libraries as soon as it makes some.
const std::string& ProgramDigest();

}  // namespace backsight
