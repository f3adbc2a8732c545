#include "pipeline/resource_budget.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/error.h"
#include "io/scan_reader.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/output_files.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

constexpr double kGigabyte = 1e9;
constexpr std::uint64_t kProgramBytes = 60'000'000;
// A stored station takes this much more in memory: index, range image, search tree (measured on
// ETH Facade and on simulated streets: 2.2 to 2.7).
constexpr double kMemoryPerStored = 2.6;
constexpr std::uint64_t kBytesPerVoxel = 124;  // stored
// Scans of a million points and more fall into 30,000 voxels at least and 200,000 on average.
constexpr std::uint64_t kFewestPointsPerVoxel = 40;
constexpr std::uint64_t kFewVoxels = 30'000;
constexpr std::uint64_t kUsualVoxels = 200'000;
constexpr std::uint64_t kLasRecordBytes = 30;
constexpr std::uint64_t kE57RecordBytes = 8;  // of three scaled integers, at the least

/// An existing folder on the way to `path`.
fs::path ExistingFolder(fs::path path) {
  std::error_code error;
  path = fs::absolute(path, error);
  while (!fs::is_directory(path, error) && path.has_relative_path()) path = path.parent_path();
  return path;
}

/// Adds up what goes to the same file system.
class DiskNeeds {
 public:
  void Add(const std::string& folder, std::uint64_t bytes) {
    const fs::path there = ExistingFolder(folder);
    struct stat status {};
    if (::stat(there.c_str(), &status) != 0) return;
    std::error_code error;
    const fs::space_info space = fs::space(there, error);
    if (error) return;
    DiskNeed& need = by_device_[status.st_dev];
    if (need.path.empty()) need.path = there.string();
    need.bytes += bytes;
    need.available = space.available;
  }
  std::vector<DiskNeed> Finish() const {
    std::vector<DiskNeed> needs;
    for (const auto& [device, need] : by_device_) needs.push_back(need);
    return needs;
  }

 private:
  std::map<dev_t, DiskNeed> by_device_;
};

std::uint64_t PointsOf(const StationSpec& spec) {
  try {
    return OpenScan(spec.scan, spec.scan_index, spec.columns)->info().point_count.value_or(0);
  } catch (const InputError&) {
    return 0;  // the run will say what is wrong with it
  }
}

std::uint64_t StoredBytes(const ArtifactStore& store, const std::string& station) {
  std::error_code error;
  const auto size = fs::file_size(store.PathOf(StationArtifactName(station)), error);
  return error ? 0 : size;
}

bool Exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

/// Clouds that are not there yet; the thinned ones may become as small as they like.
void AddClouds(const SurveyProject& project, const std::string& out_directory,
               const std::vector<std::uint64_t>& points, DiskNeeds* disks) {
  std::uint64_t all = 0;
  for (const std::uint64_t count : points) all += count;
  const auto bytes = [](const CloudOutput& cloud, std::uint64_t count) {
    if (cloud.thin_m > 0.0 || cloud.crop || cloud.without_moving) return std::uint64_t{0};
    return count * (cloud.format == CloudFormat::kE57 ? kE57RecordBytes : kLasRecordBytes);
  };
  for (const CloudOutput& cloud : MergedOutputs(project, out_directory)) {
    if (!Exists(cloud.path)) {
      disks->Add(fs::path(cloud.path).parent_path().string(), bytes(cloud, all));
    }
  }
  for (std::size_t s = 0; s < points.size() && project.outputs.stations; ++s) {
    const CloudOutput& cloud = *project.outputs.stations;
    const std::string path = StationCloudPath(cloud, project.stations[s].id);
    if (!Exists(path)) disks->Add(fs::path(path).parent_path().string(), bytes(cloud, points[s]));
  }
}

std::string Gigabytes(std::uint64_t bytes) {
  return fmt::format("{:.2f} GB", static_cast<double>(bytes) / kGigabyte);
}

/// Bytes of data this process has now.
std::uint64_t DataBytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::uint64_t kilobytes = 0;
    if (word == "VmData:" && status >> kilobytes) return kilobytes * 1024;
  }
  return 0;
}

}  // namespace

ResourceNeeds EstimateNeeds(const SurveyProject& project, const std::string& out_directory,
                            const ArtifactStore& store) {
  ResourceNeeds needs;
  DiskNeeds disks;
  std::vector<std::uint64_t> points;
  std::uint64_t least = 0;
  std::uint64_t likely = 0;
  std::uint64_t to_store = 0;
  for (const StationSpec& spec : project.stations) {
    points.push_back(PointsOf(spec));
    const std::uint64_t stored = StoredBytes(store, spec.id);
    const std::uint64_t few = std::min(points.back() / kFewestPointsPerVoxel, kFewVoxels);
    const std::uint64_t usual = std::min(points.back() / 2, kUsualVoxels);
    least += stored > 0 ? stored : few * kBytesPerVoxel;
    likely += stored > 0 ? stored : usual * kBytesPerVoxel;
    to_store += stored > 0 ? 0 : few * kBytesPerVoxel;
  }
  const std::uint64_t unknowns = 6 * project.stations.size();
  const std::uint64_t fixed = kProgramBytes + 4 * 8 * unknowns * unknowns;
  needs.least_memory =
      fixed + static_cast<std::uint64_t>(kMemoryPerStored * static_cast<double>(least));
  needs.likely_memory =
      fixed + static_cast<std::uint64_t>(kMemoryPerStored * static_cast<double>(likely));
  needs.physical_memory = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                          static_cast<std::uint64_t>(::sysconf(_SC_PAGE_SIZE));
  if (store.keeps()) disks.Add(store.folder(), to_store);
  AddClouds(project, out_directory, points, &disks);
  needs.disks = disks.Finish();
  return needs;
}

void RequireRoom(const ResourceNeeds& needs, double memory_gb, const ExecutionContext& context) {
  for (const DiskNeed& disk : needs.disks) {
    if (disk.bytes <= disk.available) continue;
    throw NoRoom(
        fmt::format("{}: this run writes {} at least, {} are free; free disk space, or "
                    "write elsewhere (--out, --work)",
                    disk.path, Gigabytes(disk.bytes), Gigabytes(disk.available)));
  }
  const auto budget = static_cast<std::uint64_t>(memory_gb * kGigabyte);
  const std::uint64_t most = std::min(budget, needs.physical_memory);
  if (needs.least_memory > most) {
    throw NoRoom(fmt::format(
        "this run takes {} of memory at least, the budget is {} and the "
        "machine has {}; raise resources.memory_gb (--memory-gb), or "
        "registration.resolution_m",
        Gigabytes(needs.least_memory), Gigabytes(budget), Gigabytes(needs.physical_memory)));
  }
  if (needs.likely_memory > most) {
    context.Warning(fmt::format("this run will probably take {} of memory, more than the {} it may",
                                Gigabytes(needs.likely_memory), Gigabytes(most)));
  }
}

bool LimitMemory(double memory_gb) {
  const auto bytes = static_cast<std::uint64_t>(memory_gb * kGigabyte);
  if (DataBytes() >= bytes) return false;  // a sanitizer reserves more than any budget
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0) return false;
  limit.rlim_cur = std::min<rlim_t>(bytes, limit.rlim_max);
  return ::setrlimit(RLIMIT_DATA, &limit) == 0;
}

}  // namespace backsight
