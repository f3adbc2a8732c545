#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "io/cloud_writer.h"
#include "io/scan_reader.h"
#include "stages/merging.h"

// Time and peak memory of merging five scans to LAS, in full and thinned, for two sizes of
// campaign: merge_memory_benchmark [MILLIONS OF POINTS, SMALL] [LARGE]. Each measurement is a
// process of its own. Fails if a peak grows by more than a tenth from the small campaign to the
// large one.

namespace backsight {
namespace {

namespace fs = std::filesystem;

constexpr int kStations = 5;
constexpr double kThinM = 0.005;
constexpr double kMostGrowth = 1.1;
constexpr double kMarginM = 0.1;
const Eigen::Vector3d kHallMin(-15.0, -10.0, -1.8);  // metres, in the shared frame
const Eigen::Vector3d kHallMax(15.0, 10.0, 6.2);

Eigen::Vector3d ScannerOf(int station) { return {6.0 * (station - 2), 3.0 - station, 0.0}; }

/// Axis of the hall's wall, floor or ceiling that a ray from `from` meets, and at which range.
struct Hit {
  int axis = 0;
  double range_m = std::numeric_limits<double>::infinity();
};

Hit HallHit(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  Hit hit;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(ray[axis]) < 1e-9) continue;
    const double wall = ray[axis] > 0.0 ? kHallMax[axis] : kHallMin[axis];
    const double range = (wall - from[axis]) / ray[axis];
    if (range < hit.range_m) hit = {axis, range};
  }
  return hit;
}

std::string ScanPath(const fs::path& folder, int station) {
  return (folder / fmt::format("{}.ply", station)).string();
}

/// A scan of the hall, column by column, with 3 mm of noise; as a stream, whatever its size.
void WriteScan(const fs::path& folder, int station, double points) {
  CloudWriterSpec spec;
  spec.path = ScanPath(folder, station);
  spec.has_intensity = true;
  const auto writer = CreatePlyWriter(spec);
  const int rows = static_cast<int>(std::sqrt(points / 2.0));
  const int columns = static_cast<int>(points / rows);
  Random random(static_cast<std::uint64_t>(station) + 1);
  PointChunk chunk;
  for (int column = 0; column < columns; ++column) {
    const double azimuth = 2.0 * std::numbers::pi * column / columns;
    for (int row = 0; row < rows; ++row) {
      const double elevation = std::numbers::pi * ((row + 0.5) / rows - 0.5);
      const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                                std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
      const double noise = std::clamp(0.003 * random.Normal(), -kMarginM, kMarginM);
      const Eigen::Vector3d point = ray * (HallHit(ScannerOf(station), ray).range_m + noise);
      chunk.x.push_back(point.x());
      chunk.y.push_back(point.y());
      chunk.z.push_back(point.z());
      chunk.intensity.push_back(static_cast<float>(random.Uniform()));
    }
    writer->Write(chunk, 1);
    chunk.Clear();
  }
  writer->Finish();
}

std::vector<MergeStation> StationsIn(const fs::path& folder) {
  std::vector<MergeStation> stations;
  for (int s = 0; s < kStations; ++s) {
    const Eigen::Vector3d scanner = ScannerOf(s);
    MergeStation station;
    station.number = s + 1;
    station.frame_from_station.translation = scanner;
    station.min = kHallMin.array() - kMarginM - scanner.array();
    station.max = kHallMax.array() + kMarginM - scanner.array();
    station.max_range_m = 100.0;
    station.has_intensity = true;
    station.open = [path = ScanPath(folder, s)] { return OpenScan(path); };
    station.cos_incidence = [scanner](const Eigen::Vector3d& p) {
      return std::abs(p[HallHit(scanner, p).axis]) / p.norm();
    };
    stations.push_back(std::move(station));
  }
  return stations;
}

std::uint64_t Merge(const fs::path& folder, double thin_m) {
  const std::vector<MergeStation> stations = StationsIn(folder);
  MergeOptions options;
  options.thin_m = thin_m;
  options.thinning.path = (folder / "merged.las").string();
  const CloudBounds bounds = MergedBounds(stations, options);
  CloudWriterSpec spec;
  spec.path = (folder / "merged.las").string();
  spec.has_intensity = true;
  spec.min = bounds.min;
  spec.max = bounds.max;
  const auto writer = CreateLasWriter(spec);
  MergeClouds(stations, options, *writer, ExecutionContext{});
  return writer->Finish();
}

struct Measured {
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  double peak_mb = 0.0;
};

double SecondsOf(const struct timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Runs `work` in a process of its own; ends the program if it fails.
Measured InChild(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  std::fflush(stdout);
  const pid_t child = ::fork();
  BACKSIGHT_CHECK(child >= 0, "no further process");
  if (child == 0) {
    try {
      work();
      std::fflush(stdout);
      ::_exit(0);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      ::_exit(1);
    }
  }
  int status = 0;
  struct rusage usage {};
  BACKSIGHT_CHECK(::wait4(child, &status, 0, &usage) == child && status == 0, "a run failed");
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  return {took.count(), SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime),
          static_cast<double>(usage.ru_maxrss) / 1024.0};
}

struct Folder {
  fs::path path = fs::temp_directory_path() / fmt::format("backsight_merge_{}", ::getpid());

  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

/// Peaks in MB of the full and of the thinned cloud.
std::array<double, 2> MeasureCampaign(double millions) {
  const Folder folder;
  const double points = 1e6 * millions;
  for (int s = 0; s < kStations; ++s) {
    InChild([&] { WriteScan(folder.path, s, points / kStations); });
  }
  std::array<double, 2> peaks{};
  for (const bool thinned : {false, true}) {
    fmt::print("{:>8g} {:>8} ", millions, thinned ? "thinned" : "full");
    const Measured run = InChild([&] {
      const std::uint64_t written = Merge(folder.path, thinned ? kThinM : 0.0);
      fmt::print("{:>8.2f} ", 1e-6 * static_cast<double>(written));
    });
    fmt::print("{:>8.1f} {:>8.1f} {:>18.2f} {:>8.1f}\n", run.seconds, run.cpu_seconds,
               millions / run.seconds, run.peak_mb);
    peaks[thinned ? 1 : 0] = run.peak_mb;
  }
  return peaks;
}

int Run(double small, double large) {
  fmt::print(
      "{} scans as PLY merged to LAS; thinned: one point per {} m\n{:>8} {:>8} {:>8} {:>8} "
      "{:>8} {:>18} {:>8}\n",
      kStations, kThinM, "millions", "", "kept", "seconds", "CPU s", "million points/s", "peak MB");
  const std::array<double, 2> before = MeasureCampaign(small);
  const std::array<double, 2> after = MeasureCampaign(large);
  const std::array<double, 2> growth{after[0] / before[0], after[1] / before[1]};
  fmt::print("peak of {:g} over peak of {:g} million points: full {:.3f}, thinned {:.3f}\n", large,
             small, growth[0], growth[1]);
  return std::max(growth[0], growth[1]) <= kMostGrowth ? 0 : 1;
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  return backsight::Run(argc > 1 ? std::atof(argv[1]) : 5.0, argc > 2 ? std::atof(argv[2]) : 50.0);
}
