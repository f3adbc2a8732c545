#pragma once

#include <cstdint>
#include <string>

namespace backsight {

/// The bytes of a regular file of at most `max_bytes`. Throws InputError if it is missing, larger,
/// no regular file, or cannot be read.
std::string ReadTextFile(const std::string& path, std::uintmax_t max_bytes = 256U << 20U);

}  // namespace backsight
