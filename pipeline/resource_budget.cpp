#include "pipeline/resource_budget.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "core/error.h"
#include "io/scan_reader.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/output_units.h"
#include "pipeline/output_files.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

constexpr double kGigabyte = 1e9;
constexpr std::uint64_t kProgramBytes = 60'000'000;  // code and libraries
// A stored station takes this much more in memory: index, range image, what finds its features and
// what its pairs need (measured: 2.0 on ETH Facade, 2.0 to 2.2 on a simulated square and hall).
constexpr double kLeastPerStored = 1.8;
constexpr double kLikelyPerStored = 2.2;
constexpr std::uint64_t kBytesPerVoxel = 46;  // stored
// Scans of a million points and more fall into 30,000 voxels at least and 200,000 on average.
constexpr std::uint64_t kFewestPointsPerVoxel = 40;
constexpr std::uint64_t kFewVoxels = 30'000;
constexpr std::uint64_t kUsualVoxels = 200'000;
constexpr std::uint64_t kRecordBytes = 26;    // of the flat formats, without intensity and colour
constexpr std::uint64_t kE57RecordBytes = 8;  // of three scaled integers
constexpr std::uint64_t kScratchBytes = 32;   // of stages/cloud_thinning, per point
// Records of E57 and PTS may be without a return; of a scan that sees much sky, three in four are.
constexpr std::uint64_t kRecordsPerSurePoint = 4;
constexpr std::uint64_t kThinningBytes = 96'000'000;  // stages/cloud_thinning
constexpr rlim_t kStackBytes = 8 * 1024 * 1024;

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
  void Add(const std::string& folder, std::uint64_t least, std::uint64_t likely) {
    Disk* const disk = Of(folder);
    if (disk == nullptr) return;
    disk->need.least += least;
    disk->need.likely += likely;
  }
  /// What one step probably takes, and gives back before another asks.
  void AddScratch(const std::string& folder, std::uint64_t likely) {
    Disk* const disk = Of(folder);
    if (disk != nullptr) disk->scratch = std::max(disk->scratch, likely);
  }
  std::vector<DiskNeed> Finish() const {
    std::vector<DiskNeed> needs;
    for (const auto& [device, disk] : by_device_) {
      needs.push_back(disk.need);
      needs.back().likely += disk.scratch;
    }
    return needs;
  }

 private:
  struct Disk {
    DiskNeed need;
    std::uint64_t scratch = 0;
  };

  /// Null where nothing can be said.
  Disk* Of(const std::string& folder) {
    const fs::path there = ExistingFolder(folder);
    struct stat status {};
    if (::stat(there.c_str(), &status) != 0) return nullptr;
    std::error_code error;
    const fs::space_info space = fs::space(there, error);
    if (error) return nullptr;
    Disk& disk = by_device_[status.st_dev];
    if (disk.need.path.empty()) disk.need.path = there.string();
    disk.need.available = space.available;
    return &disk;
  }

  std::map<dev_t, Disk> by_device_;
};

/// Points of a scan as its header has them, and how many of them must be: grids have empty cells.
struct PointCount {
  std::uint64_t points = 0;
  std::uint64_t sure = 0;
};

std::uint64_t SurePoints(const std::string& format, std::uint64_t records) {
  if (format.starts_with("LAS") || format == "PLY" || format == "PCD") return records;
  return format == "E57" || format == "PTS" ? records / kRecordsPerSurePoint : 0;
}

PointCount PointsOf(const StationSpec& spec, const ExecutionContext& context) {
  try {
    const ScanInfo info =
        OpenScan(spec.scan, spec.scan_index, spec.columns, [&] { context.CheckStop(); })->info();
    const std::uint64_t records = info.point_count.value_or(0);
    return {records, SurePoints(info.format, records)};
  } catch (const InputError&) {
    return {};  // the run will say what is wrong with it
  }
}

std::uint64_t StoredBytes(const ArtifactStore& store, const std::string& station) {
  std::error_code error;
  const auto size = fs::file_size(store.PathOf(StationArtifactName(station)), error);
  return error ? 0 : size;
}

std::uint64_t CloudBytes(const CloudOutput& cloud, std::uint64_t points) {
  return points * (cloud.format == CloudFormat::kE57 ? kE57RecordBytes : kRecordBytes);
}

/// Paths of clouds that are not to be written, because they lie there or have no station.
std::set<std::string> WrittenClouds(const std::vector<CloudOutput>& clouds,
                                    const ArtifactStore& store, const RunPlan* plan) {
  std::set<std::string> written;
  if (plan == nullptr) {
    for (const CloudOutput& cloud : clouds) {
      if (LiesAsWritten(store, cloud.path)) written.insert(cloud.path);
    }
    return written;
  }
  std::set<std::string> to_write;
  for (const PlanItem& output : plan->outputs) {
    if (!output.done() && !output.unsure) to_write.insert(output.unit);
  }
  for (const CloudOutput& cloud : clouds) {
    if (!to_write.contains(cloud.path)) written.insert(cloud.path);
  }
  return written;
}

/// Of clouds that are neither thinned nor cropped something is known.
void AddCloud(const CloudOutput& cloud, const std::set<std::string>& written, std::uint64_t sure,
              std::uint64_t likely, DiskNeeds* disks) {
  if (written.contains(cloud.path)) return;
  const std::string folder = fs::path(cloud.path).parent_path().string();
  if (cloud.thin_m > 0.0) disks->AddScratch(folder, kScratchBytes * likely);
  if (cloud.thin_m > 0.0 || cloud.crop || cloud.without_moving) return;
  // Some stations may find no place, some points lie out of range: half of the sure ones, at least.
  disks->Add(folder, CloudBytes(cloud, sure) / 2, CloudBytes(cloud, likely));
}

void AddClouds(const SurveyProject& project, const std::string& out_directory,
               const std::vector<PointCount>& counts, const std::set<std::string>& written,
               DiskNeeds* disks) {
  std::uint64_t all = 0, sure = 0;
  for (const PointCount& count : counts) {
    all += count.points;
    sure += count.sure;
  }
  for (const CloudOutput& cloud : MergedOutputs(project, out_directory)) {
    AddCloud(cloud, written, sure, all, disks);
  }
  const std::vector<CloudOutput> stations = StationOutputs(project);
  for (std::size_t s = 0; s < stations.size(); ++s) {
    AddCloud(stations[s], written, counts[s].sure, counts[s].points, disks);
  }
}

std::string SizeText(std::uint64_t bytes) {
  const auto size = static_cast<double>(bytes);
  return size < kGigabyte ? fmt::format("{:.1f} MB", size / 1e6)
                          : fmt::format("{:.1f} GB", size / kGigabyte);
}

/// Bytes of this process now, as the system counts them under `name`.
std::uint64_t BytesOf(std::string_view name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::uint64_t kilobytes = 0;
    if (word == name && status >> kilobytes) return kilobytes * 1024;
  }
  return 0;
}

}  // namespace

ResourceNeeds EstimateNeeds(const SurveyProject& project, const std::string& out_directory,
                            const ArtifactStore& store, const RunPlan* plan,
                            const ExecutionContext& context) {
  ResourceNeeds needs;
  DiskNeeds disks;
  const std::vector<CloudOutput> clouds = AllClouds(project, out_directory);
  const std::set<std::string> written = WrittenClouds(clouds, store, plan);
  const bool all_known = std::all_of(
      clouds.begin(), clouds.end(), [&](const CloudOutput& c) { return written.contains(c.path); });
  const bool thins = std::any_of(clouds.begin(), clouds.end(),
                                 [](const CloudOutput& c) { return c.thin_m > 0.0; });
  std::vector<PointCount> counts;
  std::uint64_t least = 0;
  std::uint64_t likely = 0;
  std::uint64_t to_store = 0;
  std::uint64_t likely_to_store = 0;
  for (const StationSpec& spec : project.stations) {
    const std::uint64_t stored = StoredBytes(store, spec.id);
    // A header, which may be far down its file, is read only where something depends on it.
    const PointCount& count =
        counts.emplace_back(stored > 0 && all_known ? PointCount() : PointsOf(spec, context));
    const std::uint64_t few = std::min(count.sure / kFewestPointsPerVoxel, kFewVoxels);
    const std::uint64_t usual = std::min(count.points / 2, kUsualVoxels);
    least += stored > 0 ? stored : few * kBytesPerVoxel;
    likely += stored > 0 ? stored : usual * kBytesPerVoxel;
    to_store += stored > 0 ? 0 : few * kBytesPerVoxel;
    likely_to_store += stored > 0 ? 0 : usual * kBytesPerVoxel;
  }
  const std::uint64_t unknowns = 6 * project.stations.size();
  const std::uint64_t fixed =
      kProgramBytes + 4 * 8 * unknowns * unknowns + (thins ? kThinningBytes : 0);
  needs.least_memory =
      fixed + static_cast<std::uint64_t>(kLeastPerStored * static_cast<double>(least));
  needs.likely_memory =
      fixed + static_cast<std::uint64_t>(kLikelyPerStored * static_cast<double>(likely));
  needs.physical_memory = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                          static_cast<std::uint64_t>(::sysconf(_SC_PAGE_SIZE));
  if (store.keeps()) disks.Add(store.folder(), to_store, likely_to_store);
  AddClouds(project, out_directory, counts, written, &disks);
  needs.disks = disks.Finish();
  return needs;
}

void RequireRoom(const ResourceNeeds& needs, double memory_gb, const ExecutionContext& context) {
  for (const DiskNeed& disk : needs.disks) {
    if (disk.least > disk.available) {
      throw NoRoom(
          fmt::format("{}: this run writes {} at least, {} are free; free disk space, or "
                      "write elsewhere (--out, --work)",
                      disk.path, SizeText(disk.least), SizeText(disk.available)));
    }
    if (disk.likely > disk.available) {
      context.Warning(fmt::format("{}: this run will probably write {}, {} are free", disk.path,
                                  SizeText(disk.likely), SizeText(disk.available)));
    }
  }
  const auto budget = static_cast<std::uint64_t>(memory_gb * kGigabyte);
  const std::uint64_t most = std::min(budget, needs.physical_memory);
  if (needs.least_memory > most) {
    throw NoRoom(fmt::format(
        "this run takes {} of memory at least, the budget is {} and the "
        "machine has {}; raise resources.memory_gb (--memory-gb), or "
        "registration.resolution_m",
        SizeText(needs.least_memory), SizeText(budget), SizeText(needs.physical_memory)));
  }
  if (needs.likely_memory > most) {
    context.Warning(fmt::format("this run will probably take {} of memory, more than the {} it may",
                                SizeText(needs.likely_memory), SizeText(most)));
  }
}

NoRoom MemoryUsedUp(const std::string& place, double memory_gb) {
  return NoRoom(
      fmt::format("{}: the budget of {:g} GB of memory is used up; raise "
                  "resources.memory_gb (--memory-gb)",
                  place, memory_gb));
}

void WakeThreads(const ExecutionContext& context) {
  const int threads = context.threads();
  std::atomic<int> awake = 0;
  const auto patience = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
  context.ParallelFor(static_cast<std::size_t>(threads), [&](std::size_t) {
    ++awake;
    while (awake < threads && std::chrono::steady_clock::now() < patience)
      std::this_thread::yield();
  });
}

bool LimitMemory(double memory_gb, int threads) {
  // The limit is on data alone: the program's own pages come on top.
  const auto program = std::max(kProgramBytes, BytesOf("RssFile:"));
  const auto bytes =
      static_cast<rlim_t>(memory_gb * kGigabyte) + static_cast<rlim_t>(threads) * kStackBytes;
  // A sanitizer reserves more than any budget.
  if (program + BytesOf("VmData:") >= bytes) return false;
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0) return false;
  limit.rlim_cur = std::min(bytes - program, limit.rlim_max);
  return ::setrlimit(RLIMIT_DATA, &limit) == 0;
}

}  // namespace backsight
