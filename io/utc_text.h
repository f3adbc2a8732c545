#pragma once

#include <chrono>
#include <string>

namespace backsight {

/// ISO 8601 in whole seconds: "2024-06-07T21:00:00Z".
std::string UtcText(std::chrono::system_clock::time_point time);

}  // namespace backsight
