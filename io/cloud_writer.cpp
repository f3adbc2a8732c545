#include "io/cloud_writer.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "io/output_names.h"

namespace backsight {

std::vector<WrittenFile> WrittenFiles(const CloudWriterSpec& spec, std::uint64_t points) {
  const std::uint64_t most = spec.max_points_per_file;
  if (most == 0 || points <= most) return {{spec.path, points}};
  std::vector<WrittenFile> files;
  for (std::uint64_t left = points; left > 0; left -= files.back().points) {
    files.push_back({PartPath(spec.path, files.size() + 1), std::min(left, most)});
  }
  return files;
}

void RequireStationNumber(const std::string& path, int station_number) {
  if (station_number >= 1 && station_number <= 65535) return;
  throw InputError({path, fmt::format("station number {}", station_number), "1 to 65535",
                    "merge fewer stations into one file"});
}

}  // namespace backsight
