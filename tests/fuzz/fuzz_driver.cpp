#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "core/error.h"
#include "io/utf8.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

/// A file in memory that readers can open by its path.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : file_(::memfd_create("fuzzed", MFD_CLOEXEC)) {
    BACKSIGHT_CHECK(file_ >= 0, "no memory file");
    const ssize_t put = ::write(file_, bytes.data(), bytes.size());
    BACKSIGHT_CHECK(put == static_cast<ssize_t>(bytes.size()), "no room for a memory file");
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

void CheckChunk(const PointChunk& chunk, const ScanInfo& info) {
  const std::size_t n = chunk.size();
  BACKSIGHT_CHECK(n <= 65536 && chunk.y.size() == n && chunk.z.size() == n, "uneven columns");
  BACKSIGHT_CHECK(chunk.intensity.size() == (info.has_intensity ? n : 0), "uneven intensity");
  BACKSIGHT_CHECK(chunk.rgb.size() == (info.has_rgb ? n : 0), "uneven colour");
  BACKSIGHT_CHECK(chunk.classification.size() == (info.has_classification ? n : 0),
                  "uneven classification");
  BACKSIGHT_CHECK(chunk.gps_time.size() == (info.has_gps_time ? n : 0), "uneven GPS time");
  const std::size_t cells = info.rows > 0 ? n : 0;
  BACKSIGHT_CHECK(chunk.row.size() == cells && chunk.column.size() == cells, "uneven cells");
  for (std::size_t i = 0; i < cells; ++i) {
    BACKSIGHT_CHECK(chunk.row[i] >= 0 && chunk.row[i] < info.rows, "a row beyond the grid");
    BACKSIGHT_CHECK(chunk.column[i] >= 0 && chunk.column[i] < info.columns,
                    "a column beyond the grid");
  }
  for (std::size_t i = 0; i < n; ++i) {
    BACKSIGHT_CHECK(
        std::isfinite(chunk.x[i]) && std::isfinite(chunk.y[i]) && std::isfinite(chunk.z[i]),
        "a coordinate that is not finite");
  }
  for (const float intensity : chunk.intensity) {
    BACKSIGHT_CHECK(intensity >= 0.0F && intensity <= 1.0F, "intensity beyond 0 to 1");
  }
}

void ReadScan(ScanReader& reader) {
  const ScanInfo& info = reader.info();
  BACKSIGHT_CHECK(CleanUtf8(info.crs) == info.crs, "a reference system that is not UTF-8");
  if (info.world_from_scan) {
    BACKSIGHT_CHECK(info.world_from_scan->IsValid(), "a pose that is no rigid motion");
  }
  PointChunk chunk;
  std::uint64_t points = 0;
  while (reader.Next(chunk)) {
    CheckChunk(chunk, info);
    points += chunk.size();
  }
  const ScanTally& tally = reader.tally();
  BACKSIGHT_CHECK(tally.points == points, "points that were not counted");
  BACKSIGHT_CHECK(
      tally.records == tally.points + tally.not_finite + tally.no_return + tally.withheld,
      "records that were not counted");
  BACKSIGHT_CHECK(!info.point_count || tally.records == *info.point_count, "records missing");
}

void WriteSeeds(const std::string& folder) {
  int number = 0;
  for (const std::string& seed : TargetUnderTest().seeds()) {
    std::ofstream(folder + "/seed" + std::to_string(number++), std::ios::binary) << seed;
  }
  std::cout << number << " seeds written to " << folder << '\n';
}

}  // namespace

void ReadScans(const std::string& path, OpenFunction open) {
  int scans = 1;
  for (int i = 0; i < std::min(scans, 3); ++i) {
    const std::unique_ptr<ScanReader> reader = open(path, i);
    scans = reader->info().scan_count;
    ReadScan(*reader);
  }
}

bool ReadFuzzed(const FuzzTarget& target, std::string_view input) {
  const MemoryFile file(target.file_of(input));
  try {
    target.read(file.path());
  } catch (const InputError& error) {
    BACKSIGHT_CHECK(error.details().where.starts_with(file.path()), "an error without its file");
    BACKSIGHT_CHECK(CleanUtf8(error.what()) == error.what(), "a message that is not UTF-8");
    return false;
  }
  return true;
}

}  // namespace backsight

// libFuzzer calls these two. `fuzz_<reader> --seeds=FOLDER` writes the seeds and ends.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  constexpr std::string_view kSeeds = "--seeds=";
  for (int i = 1; i < *argc; ++i) {
    const std::string_view argument = (*argv)[i];
    if (!argument.starts_with(kSeeds)) continue;
    backsight::WriteSeeds(std::string(argument.substr(kSeeds.size())));
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  backsight::ReadFuzzed(backsight::TargetUnderTest(), input);
  return 0;
}
