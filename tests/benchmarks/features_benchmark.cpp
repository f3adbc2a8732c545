#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/voxel_shards.h"
#include "io/scan_reader.h"
#include "stages/features.h"
#include "stages/fpfh.h"
#include "stages/leaf_grid.h"
#include "stages/normal_orientation.h"
#include "stages/normals.h"
#include "tests/support/feature_scene.h"
#include "tests/support/pcl_features.h"
#include "tests/support/street_scene.h"

// Features of a small simulated station, a station of ETH Facade and a simulated scan of 10 million
// points, ours and PCL's with the same radii and key points in one run. Times are medians, of one
// thread in the processor's time, which other programs on the machine disturb least:
//   features_benchmark [yard] [eth] [street]     (all if none is named)

namespace backsight {
namespace {

constexpr double kResolution = 0.1;
constexpr double kCellEdge = 4.0 * kResolution;  // as ComputeFeatures takes it

struct Cloud {
  std::string name;
  std::vector<Eigen::Vector3d> points;
  int pcl_runs = 3;
  StationModel model = MakeStation(points, kResolution);
};

enum class Clock { kProcessor, kWall };

double NowMs(Clock clock) {
  if (clock == Clock::kProcessor) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

/// Median time of `runs` runs.
double Milliseconds(int runs, Clock clock, const std::function<void()>& body) {
  std::vector<double> times;
  for (int run = 0; run < runs; ++run) {
    const double start = NowMs(clock);
    body();
    times.push_back(NowMs(clock) - start);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

struct StepTimes {
  double gathering = 0.0, sorting = 0.0, normals = 0.0, orientation = 0.0, iss = 0.0, fpfh = 0.0,
         all = 0.0;
};

/// Radii as ComputeFeatures takes them by default.
IssParameters DefaultIss() {
  return {.salient_radius_m = 6.0 * kResolution,
          .non_max_radius_m = 4.0 * kResolution,
          .keypoints = FeatureOptions().keypoints};
}

/// Count, mean and scatter matrix of the points in every voxel, as scans are read: chunk by chunk.
VoxelLeaves Gather(std::span<const Eigen::Vector3d> points, const ExecutionContext& context) {
  constexpr std::size_t kChunk = 65536;
  const VoxelLattice lattice{.edge_m = kResolution};
  VoxelShards shards(lattice);
  std::vector<VoxelShards::Batch> batches(context.StreamSlots());
  std::vector<std::span<const Eigen::Vector3d>> chunks(batches.size());
  const auto read = [&](std::size_t slot) {
    chunks[slot] = points.first(std::min(points.size(), kChunk));
    points = points.subspan(chunks[slot].size());
    return !chunks[slot].empty();
  };
  const auto place = [&](std::size_t slot) {
    batches[slot].Clear();
    for (const Eigen::Vector3d& point : chunks[slot]) batches[slot].Add(lattice, point);
    batches[slot].Sort();
  };
  context.Stream(batches.size(), read, place,
                 [&](std::size_t slot) { shards.Add(batches[slot], context); });
  return shards.Finish();
}

StepTimes TimeOurs(const Cloud& cloud, int threads) {
  constexpr int kRuns = 7;
  const Clock clock = threads == 1 ? Clock::kProcessor : Clock::kWall;
  const ExecutionContext context(threads);
  const std::vector<Eigen::Vector3f> points = LeafPositions(cloud.model);
  const LeafGrid grid(points, kCellEdge);
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::uint32_t> keypoints;
  StepTimes times;
  times.gathering = Milliseconds(kRuns, clock, [&] { Gather(cloud.points, context); });
  times.sorting = Milliseconds(kRuns, clock, [&] { LeafGrid(points, kCellEdge); });
  times.normals = Milliseconds(
      kRuns, clock, [&] { normals = EstimateNormals(grid, 3.0 * kResolution, context); });
  times.orientation =
      Milliseconds(kRuns, clock, [&] { OrientNormals(cloud.model, context, &normals); });
  times.iss = Milliseconds(kRuns, clock,
                           [&] { keypoints = FindIssKeypoints(grid, DefaultIss(), context); });
  times.fpfh = Milliseconds(
      kRuns, clock, [&] { ComputeFpfh(grid, normals, keypoints, 8.0 * kResolution, context); });
  times.all = Milliseconds(kRuns, clock, [&] { ComputeFeatures(cloud.model, {}, context); });
  return times;
}

struct PclResult {
  StepTimes times;
  std::size_t keypoints = 0;
  bool same_keypoints = false;
  std::size_t voxels = 0;
  double fpfh_difference = 0.0;
};

PclResult TimePcl(const Cloud& cloud) {
  const ExecutionContext context(0);
  const std::vector<Eigen::Vector3f> points = LeafPositions(cloud.model);
  const LeafGrid grid(points, kCellEdge);
  const std::vector<Eigen::Vector3f> normals = EstimateNormals(grid, 3.0 * kResolution, context);
  const auto ours = FindIssKeypoints(grid, DefaultIss(), context);
  // PCL does not shorten the radius of suppression by itself: it gets the one at which ours ended.
  IssParameters iss = DefaultIss();
  iss.keypoints = 0;
  while (FindIssKeypoints(grid, iss, context) != ours) {
    iss.non_max_radius_m -= DefaultIss().non_max_radius_m / 8.0;
  }
  PclResult result;
  result.keypoints = ours.size();
  std::vector<std::uint32_t> keypoints;
  std::vector<FpfhDescriptor> descriptors;
  StepTimes& times = result.times;
  const auto voxel_grid = PclVoxelGrid(cloud.points, kResolution);
  times.gathering =
      Milliseconds(cloud.pcl_runs, Clock::kProcessor, [&] { result.voxels = voxel_grid().size(); });
  times.normals = Milliseconds(cloud.pcl_runs, Clock::kProcessor,
                               [&] { PclNormals(points, 3.0 * kResolution); });
  times.iss = Milliseconds(cloud.pcl_runs, Clock::kProcessor,
                           [&] { keypoints = PclIssKeypoints(points, iss); });
  times.fpfh = Milliseconds(cloud.pcl_runs, Clock::kProcessor, [&] {
    descriptors = PclFpfh(points, normals, ours, 8.0 * kResolution);
  });
  times.all = times.normals + times.iss + times.fpfh;
  result.same_keypoints = keypoints == ours;
  result.fpfh_difference = MedianRelativeDifference(
      ComputeFpfh(grid, normals, ours, 8.0 * kResolution, context), descriptors);
  return result;
}

void PrintRow(const char* step, std::size_t voxels, double one, double all_threads, double pcl) {
  const std::string reference = pcl > 0.0 ? fmt::format("{:10.1f} {:8.1f}", pcl, pcl / one) : "";
  fmt::print("  {:22} {:10.1f} {:10.2f} {:12.1f} {}\n", step, one,
             1e-3 * static_cast<double>(voxels) / one, all_threads, reference);
}

void Compare(const Cloud& cloud) {
  const std::size_t voxels = cloud.model.leaves.size();
  const StepTimes one = TimeOurs(cloud, 1);
  const StepTimes all = TimeOurs(cloud, 0);
  const PclResult pcl = TimePcl(cloud);
  fmt::print("{}: {} points, {} voxels, {} key points\n", cloud.name, cloud.model.points, voxels,
             pcl.keypoints);
  fmt::print("  {:22} {:>10} {:>10} {:>12} {:>10} {:>8}\n", "", "1 thread,", "million",
             fmt::format("{} threads,", ExecutionContext(0).threads()), "PCL,", "factor,");
  fmt::print("  {:22} {:>10} {:>10} {:>12} {:>10} {:>8}\n", "step", "ms", "voxels/s", "ms", "ms",
             "1 thread");
  PrintRow("points into voxels", voxels, one.gathering, all.gathering, pcl.times.gathering);
  PrintRow("sorting into cells", voxels, one.sorting, all.sorting, 0.0);
  PrintRow("normals", voxels, one.normals, all.normals, pcl.times.normals);
  PrintRow("orientation of normals", voxels, one.orientation, all.orientation, 0.0);
  PrintRow("ISS key points", voxels, one.iss, all.iss, pcl.times.iss);
  PrintRow("FPFH", voxels, one.fpfh, all.fpfh, pcl.times.fpfh);
  PrintRow("all", voxels, one.all, all.all, pcl.times.all);
  fmt::print("  PCL finds {} voxels; key points {} PCL's, ", pcl.voxels,
             pcl.same_keypoints ? "identical to" : "DIFFER from");
  fmt::print("median relative difference of FPFH {:.1e}\n\n", pcl.fpfh_difference);
  std::fflush(stdout);
}

void CompareEth() {
  const char* root = std::getenv("BACKSIGHT_DATA");
  const std::string path =
      std::string(root != nullptr ? root : "../shared/data") + "/eth_facade/s1.pcd";
  if (!std::filesystem::exists(path)) {
    fmt::print("eth: skipped, there is no {}\n\n", path);
    return;
  }
  const auto reader = OpenScan(path);
  std::vector<Eigen::Vector3d> points;
  PointChunk chunk;
  while (reader->Next(chunk)) {
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      points.emplace_back(chunk.x[i], chunk.y[i], chunk.z[i]);
    }
  }
  Compare({"eth", std::move(points)});
}

void Run(const std::vector<std::string>& names) {
  const auto wanted = [&](const char* name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  };
  if (wanted("yard")) Compare({"yard", ScanYard(7, 4.0)});
  if (wanted("eth")) CompareEth();
  if (wanted("street")) Compare({"street", ScanStreet(ExecutionContext(0)), 1});
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  backsight::Run(std::vector<std::string>(argv + 1, argv + argc));
  return 0;
}
