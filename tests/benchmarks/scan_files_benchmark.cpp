#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>

#include "core/error.h"
#include "core/execution.h"
#include "core/random.h"
#include "io/cloud_writer.h"
#include "io/e57/e57_writer.h"
#include "io/ptx_writer.h"
#include "io/scan_reader.h"
#include "io/scan_stream.h"
#include "tests/benchmarks/pcl_clouds.h"

// How fast scan files are read, on one thread unless stated, and LAS is written, beside what `cat`
// and PCL's readers need for the same files: scan_files_benchmark [MILLIONS OF POINTS].

namespace backsight {
namespace {

constexpr int kRounds = 3;
constexpr double kMarginM = 0.1;
const Eigen::Vector3d kHallMin(-15.0, -10.0, -1.8);
const Eigen::Vector3d kHallMax(15.0, 10.0, 6.2);

/// A scan from within a hall, column by column.
struct Scan {
  int columns = 0;
  int rows = 0;
  std::vector<PointChunk> chunks;

  double Points() const { return static_cast<double>(columns) * rows; }
};

/// The point that the scanner sees in direction (azimuth, elevation), with 3 mm of noise.
Eigen::Vector3d HallPoint(double azimuth, double elevation, Random& random) {
  const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                            std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  double range = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double wall = ray[axis] > 0.0 ? kHallMax[axis] : kHallMin[axis];
    if (std::abs(ray[axis]) > 1e-9) range = std::min(range, wall / ray[axis]);
  }
  return ray * (range + std::clamp(0.003 * random.Normal(), -kMarginM, kMarginM));
}

Scan MakeScan(double points) {
  constexpr std::size_t kChunk = 65536;
  constexpr double kPi = 3.14159265358979323846;
  Scan scan;
  scan.rows = std::max(1, static_cast<int>(std::sqrt(points / 2.0)));
  scan.columns = std::max(1, static_cast<int>(points / scan.rows));
  Random random(1);
  for (int column = 0; column < scan.columns; ++column) {
    for (int row = 0; row < scan.rows; ++row) {
      if (scan.chunks.empty() || scan.chunks.back().size() == kChunk) scan.chunks.emplace_back();
      PointChunk& chunk = scan.chunks.back();
      const Eigen::Vector3d point = HallPoint(2.0 * kPi * column / scan.columns,
                                              kPi * ((row + 0.5) / scan.rows - 0.5), random);
      chunk.x.push_back(point.x());
      chunk.y.push_back(point.y());
      chunk.z.push_back(point.z());
      chunk.intensity.push_back(static_cast<float>(random.Uniform()));
      std::array<std::uint16_t, 3> rgb{};
      for (std::uint16_t& c : rgb) c = static_cast<std::uint16_t>(257 * random.Index(256));
      chunk.rgb.push_back(rgb);
    }
  }
  return scan;
}

void WritePtx(const std::string& path, const Scan& scan) {
  PtxWriter writer(path);
  writer.BeginScan({scan.columns, scan.rows, true, {}});
  for (const PointChunk& chunk : scan.chunks) {
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      std::array<std::uint8_t, 3> rgb{};
      for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(chunk.rgb[i][c] >> 8U);
      writer.AddPoint({chunk.x[i], chunk.y[i], chunk.z[i]}, chunk.intensity[i], rgb);
    }
  }
  writer.Finish();
}

void WriteE57(const std::string& path, const Scan& scan, E57Coordinates coordinates) {
  E57Writer writer({path, "file", "benchmark", "", std::nullopt});
  E57ScanSpec spec;
  spec.guid = "scan";
  spec.coordinates = coordinates;
  spec.min = kHallMin.array() - kMarginM;
  spec.max = kHallMax.array() + kMarginM;
  spec.has_intensity = spec.has_rgb = true;
  writer.BeginScan(spec);
  for (const PointChunk& chunk : scan.chunks) writer.Write(chunk);
  writer.EndScan();
  writer.Finish();
}

using CreateWriter = std::unique_ptr<CloudWriter> (*)(const CloudWriterSpec& spec);

void WriteCloud(const std::string& path, const Scan& scan, CreateWriter create) {
  CloudWriterSpec spec;
  spec.path = path;
  spec.has_intensity = spec.has_rgb = true;
  spec.min = kHallMin.array() - kMarginM;
  spec.max = kHallMax.array() + kMarginM;
  const std::unique_ptr<CloudWriter> writer = create(spec);
  for (const PointChunk& chunk : scan.chunks) writer->Write(chunk, 1);
  writer->Finish();
}

void ReadScan(const std::string& path, const Scan& scan) {
  const std::unique_ptr<ScanReader> reader = OpenScan(path);
  PointChunk chunk;
  while (reader->Next(chunk)) {
  }
  BACKSIGHT_CHECK(static_cast<double>(reader->tally().points) == scan.Points(), "points are lost");
}

/// The same on all threads.
void StreamFile(const std::string& path, const Scan& scan) {
  const std::unique_ptr<ScanReader> reader = OpenScan(path);
  const ExecutionContext context(0);
  const auto nothing = [](std::size_t, const PointChunk&) {};
  StreamScan(*reader, context.StreamSlots(), context, nothing, nothing);
  BACKSIGHT_CHECK(static_cast<double>(reader->tally().points) == scan.Points(), "points are lost");
}

/// The shortest of several runs.
double SecondsOf(const std::function<void()>& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    best = std::min(best, took.count());
  }
  return best;
}

void Report(const std::string& what, const std::string& path, double points, double seconds) {
  const double megabytes = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
  const double cat = SecondsOf([&] {
    BACKSIGHT_CHECK(std::system(("cat '" + path + "' > /dev/null").c_str()) == 0, "no cat");
  });
  fmt::print("{:26} {:8.1f} {:16.2f} {:10.0f} {:10.0f} {:10.1f}\n", what, megabytes,
             points / seconds / 1e6, megabytes / seconds, megabytes / cat, seconds / cat);
  std::fflush(stdout);
}

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "backsight_scan_files";

  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

void Run(double millions) {
  const Folder folder;
  const Scan scan = MakeScan(1e6 * millions);
  const auto file = [&](const char* name) { return (folder.path / name).string(); };
  const auto report = [&](const std::string& what, const std::string& path,
                          const std::function<void()>& work) {
    Report(what, path, scan.Points(), SecondsOf(work));
  };
  const auto read = [&](const std::string& what, const std::string& path) {
    report(what, path, [&] { ReadScan(path, scan); });
  };
  fmt::print(
      "{:.0f} points with intensity and colour; shortest of {} runs\n{:26} {:>8} {:>16} "
      "{:>10} {:>10} {:>10}\n",
      scan.Points(), kRounds, "", "MB", "million points/s", "MB/s", "cat MB/s", "time/cat");
  WriteE57(file("double.e57"), scan, E57Coordinates::kDouble);
  read("read E57, double", file("double.e57"));
  WriteE57(file("scaled.e57"), scan, E57Coordinates::kScaledInteger);
  read("read E57, scaled integers", file("scaled.e57"));
  WritePtx(file("scan.ptx"), scan);
  read("read PTX", file("scan.ptx"));
  report("the same, all threads", file("scan.ptx"), [&] { StreamFile(file("scan.ptx"), scan); });
  WriteCloud(file("scan.las"), scan, &CreateLasWriter);
  read("read LAS", file("scan.las"));
  report("the same, all threads", file("scan.las"), [&] { StreamFile(file("scan.las"), scan); });
  WriteCloud(file("scan.ply"), scan, &CreatePlyWriter);
  read("read PLY, double", file("scan.ply"));
  WriteCloud(file("scan.pcd"), scan, &CreatePcdWriter);
  read("read PCD, double", file("scan.pcd"));
  WritePclPly(file("float.ply"), scan.chunks);
  read("read PLY, float, grey", file("float.ply"));
  report("the same with PCL", file("float.ply"), [&] { ReadPclPly(file("float.ply")); });
  WritePclPcd(file("float.pcd"), scan.chunks);
  read("read PCD, float, grey", file("float.pcd"));
  report("the same with PCL", file("float.pcd"), [&] { ReadPclPcd(file("float.pcd")); });
  report("write LAS and verify it", file("scan.las"),
         [&] { WriteCloud(file("scan.las"), scan, &CreateLasWriter); });
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  backsight::Run(argc > 1 ? std::atof(argv[1]) : 2.0);
  return 0;
}
