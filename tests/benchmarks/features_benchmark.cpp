#include <benchmark/benchmark.h>

#include "stages/features.h"
#include "stages/fpfh.h"
#include "stages/leaf_grid.h"
#include "stages/normal_orientation.h"
#include "stages/normals.h"
#include "tests/support/feature_scene.h"
#include "tests/support/pcl_features.h"

// Ours against PCL, one thread, on the same simulated station of some 50,000 voxels.

namespace backsight {
namespace {

struct Station {
  StationModel model = MakeYardStation(7, 4.0);
  std::vector<Eigen::Vector3f> points = LeafPositions(model);
  double l = model.resolution_m();
  ExecutionContext context{1};
  LeafGrid grid{points, 3.0 * l};
  IssParameters iss{.salient_radius_m = 6.0 * l, .non_max_radius_m = 4.0 * l};
  StationFeatures features = ComputeFeatures(model, {}, context);
};

const Station& TheStation() {
  static const Station station;
  return station;
}

void Report(benchmark::State& state) {
  const Station& s = TheStation();
  state.counters["voxels"] = static_cast<double>(s.points.size());
  state.counters["keypoints"] = static_cast<double>(s.features.keypoints.size());
}

void BM_Grid(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) benchmark::DoNotOptimize(LeafGrid(s.points, 3.0 * s.l));
  Report(state);
}

void BM_Normals(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) {
    benchmark::DoNotOptimize(EstimateNormals(s.grid, 3.0 * s.l, s.context));
  }
}

void BM_NormalsPcl(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) benchmark::DoNotOptimize(PclNormals(s.points, 3.0 * s.l));
}

void BM_Orientation(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) {
    std::vector<Eigen::Vector3f> normals = s.features.normals;
    benchmark::DoNotOptimize(OrientNormals(s.model, false, s.context, &normals));
  }
}

void BM_Iss(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) benchmark::DoNotOptimize(FindIssKeypoints(s.grid, s.iss, s.context));
}

void BM_IssPcl(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) benchmark::DoNotOptimize(PclIssKeypoints(s.points, s.iss));
}

void BM_Fpfh(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        ComputeFpfh(s.grid, s.features.normals, s.features.keypoints, 8.0 * s.l, s.context));
  }
}

void BM_FpfhPcl(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        PclFpfh(s.points, s.features.normals, s.features.keypoints, 8.0 * s.l));
  }
}

void BM_ComputeFeatures(benchmark::State& state) {
  const Station& s = TheStation();
  for (auto _ : state) benchmark::DoNotOptimize(ComputeFeatures(s.model, {}, s.context));
}

BENCHMARK(BM_Grid)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Normals)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_NormalsPcl)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Orientation)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Iss)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_IssPcl)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Fpfh)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FpfhPcl)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_ComputeFeatures)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace backsight
