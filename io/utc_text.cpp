#include "io/utc_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace backsight {

std::string UtcText(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     std::chrono::time_point_cast<std::chrono::seconds>(time));
}

}  // namespace backsight
