#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace backsight {

/// "S1, S2, S3 and others": at most `most` names, so that a warning can be read.
std::string FirstNames(std::span<const std::string> names, std::size_t most = 10);

}  // namespace backsight
