#include <fmt/format.h>
#include <sys/resource.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/random.h"
#include "core/voxel_grid.h"
#include "graph/planar_adjustment.h"
#include "stages/network_refinement.h"
#include "tests/benchmarks/ceres_planes.h"
#include "tests/support/synthetic_network.h"

// Planar adjustment over the stations of a synthetic town, by default 200 with more than 100,000
// planes; then, of the planes as the start poses show them, PA-AA and Ceres with automatic
// differentiation to the least of the same cost:
//   network_refinement_benchmark [THREADS [ROWS COLUMNS]]

namespace backsight {
namespace {

constexpr double kSpacing = 14.0;  // m, between stations and between walls
constexpr double kReach = 13.0;    // m, how far a station sees
constexpr double kHeight = 8.0;    // m, of the walls
constexpr double kStep = 0.2;      // m, between points
constexpr double kNoise = 0.003;   // m

double Jitter(Random& random) { return random.Uniform(-0.08, 0.08); }

/// Points of the ground and of the walls halfway between the rows and columns of stations.
StationModel Measure(Random& random, const RigidTransform& survey_from_station) {
  VoxelClusterer clusterer({.edge_m = 0.1});
  const RigidTransform station_from_survey = survey_from_station.Inverse();
  const Eigen::Vector3d at = survey_from_station.translation;
  const auto add = [&](const Eigen::Vector3d& p) {
    if ((p - at).norm() > kReach) return;
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    clusterer.Add(station_from_survey * p + kNoise * noise);
  };
  const int reach = static_cast<int>(kReach / kStep);
  const auto snapped = [](double x) { return kStep * std::round(x / kStep); };
  for (int i = -reach; i <= reach; ++i) {
    const double x = snapped(at.x()) + i * kStep;
    const double y = snapped(at.y()) + i * kStep;
    for (int j = -reach; j <= reach; ++j) {
      add({x + Jitter(random), snapped(at.y()) + j * kStep + Jitter(random), -1.65});
    }
    for (double z = -1.4; z < kHeight; z += kStep) {
      for (int wall = -1; wall <= 1; ++wall) {
        const double wall_x = kSpacing * (std::round(at.x() / kSpacing) + wall) + 0.45 * kSpacing;
        const double wall_y = kSpacing * (std::round(at.y() / kSpacing) + wall) + 0.45 * kSpacing;
        add({wall_x, y + Jitter(random), z + Jitter(random)});
        add({x + Jitter(random), wall_y, z + Jitter(random)});
      }
    }
  }
  StationModel model;
  model.leaves = clusterer.Finish();
  return model;
}

std::vector<RigidTransform> PlaceStations(Random& random, int rows, int columns) {
  std::vector<RigidTransform> poses;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const bool datum = poses.empty();
      const Eigen::Vector3d position(kSpacing * column + (datum ? 0.0 : random.Uniform(-2.0, 2.0)),
                                     kSpacing * row + (datum ? 0.0 : random.Uniform(-2.0, 2.0)),
                                     0.0);
      const Eigen::Vector3d heading(0.0, 0.0, datum ? 0.0 : random.Uniform(-3.0, 3.0));
      poses.push_back({ExpSo3(heading), position});
    }
  }
  return poses;
}

std::vector<PoseGraphLink> LinkNeighbors(Random& random, const std::vector<RigidTransform>& truth) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.02 * std::numbers::pi / 180.0),
      Eigen::Vector3d::Constant(0.004);
  std::vector<PoseGraphLink> links;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t s = t + 1; s < truth.size(); ++s) {
      const RigidTransform target_from_source = truth[t].Inverse() * truth[s];
      if (target_from_source.translation.norm() > 1.6 * kSpacing) continue;
      Vector6d draw;
      for (int i = 0; i < 6; ++i) draw[i] = sigma[i] * random.Normal();
      links.push_back({static_cast<int>(s), static_cast<int>(t), Retract(target_from_source, draw),
                       sigma.cwiseAbs2().cwiseInverse().asDiagonal()});
    }
  }
  return links;
}

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

double MeanDistance(const std::vector<RigidTransform>& a, const std::vector<RigidTransform>& b) {
  double sum = 0.0;
  for (std::size_t s = 1; s < a.size(); ++s) sum += (a[s].translation - b[s].translation).norm();
  return sum / static_cast<double>(a.size() - 1);
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The planes of all stations at the start poses, one weight for all.
void CompareWithCeres(const NetworkRefinementInput& input, const ExecutionContext& context) {
  std::vector<ClusterList> clusters;
  for (const StationModel* model : input.stations) clusters.emplace_back(model->leaves);
  std::vector<WeightedPlane> planes;
  std::size_t observations = 0;
  for (PlaneAssociation& plane :
       FindPlanes(clusters, input.survey_from_station, PlaneSearchOptions{}, &context)) {
    observations += plane.observations.size();
    planes.push_back({std::move(plane.observations), 1.0 / (kNoise * kNoise)});
  }
  const PlanarAdjustmentOptions options;
  auto start = std::chrono::steady_clock::now();
  const PlanarAdjustmentResult ours =
      AdjustPlanes({planes, {}, &context}, input.survey_from_station, 0, options);
  const double our_seconds = SecondsSince(start);
  start = std::chrono::steady_clock::now();
  const CeresPlanesResult theirs = AdjustPlanesWithCeres(
      planes, input.survey_from_station, 0, options.relative_decrease, context.threads());
  const double their_seconds = SecondsSince(start);
  double apart_m = 0.0;
  for (std::size_t s = 0; s < ours.poses.size(); ++s) {
    apart_m = std::max(apart_m, (ours.poses[s].translation - theirs.poses[s].translation).norm());
  }
  fmt::print("planes {} observations {}\n", planes.size(), observations);
  fmt::print("PA-AA: {:.2f} s, {} steps ({} by Anderson), cost {:.6g} -> {:.6g}\n", our_seconds,
             ours.iterations, ours.anderson_accepted, ours.start_cost, ours.final_cost);
  fmt::print("Ceres: {:.2f} s, {} steps, cost {:.6g}, {}converged\n", their_seconds,
             theirs.iterations, theirs.final_cost, theirs.converged ? "" : "not ");
  fmt::print("Ceres / PA-AA: {:.1f}; stations apart by at most {:.4f} mm\n",
             their_seconds / our_seconds, 1e3 * apart_m);
}

void Run(int threads, int rows, int columns) {
  const ExecutionContext context(threads);
  Random random(1);
  const std::vector<RigidTransform> truth = PlaceStations(random, rows, columns);
  std::vector<StationModel> models;
  std::size_t voxels = 0;
  for (const RigidTransform& pose : truth) {
    models.push_back(Measure(random, pose));
    voxels += models.back().leaves.size();
  }
  NetworkRefinementInput input;
  for (const StationModel& model : models) input.stations.push_back(&model);
  input.links = LinkNeighbors(random, truth);
  const PoseGraphResult graph = SolveWithCovariance(static_cast<int>(truth.size()), input.links);
  input.survey_from_station = graph.survey_from_station;
  input.covariance = graph.covariance;
  fmt::print("stations {} voxels {} links {} threads {} memory before {:.0f} MB\n", truth.size(),
             voxels, input.links.size(), context.threads(), PeakMemoryMb());
  std::fflush(stdout);

  const auto start = std::chrono::steady_clock::now();
  const NetworkRefinementResult result = RefineNetwork(input, {}, context);
  const double seconds = SecondsSince(start);
  for (const RefinementRound& round : result.rounds) {
    fmt::print(
        "planes {} observations {} iterations {} anderson {} start {} cost {:.6g} -> {:.6g} "
        "largest move {:.3f} mm\n",
        round.planes, round.observations, round.iterations, round.anderson_accepted,
        round.anderson_start, round.cost_before, round.cost_after, 1e3 * round.largest_move_m);
  }
  const auto unknowns = static_cast<Eigen::Index>(6 * (truth.size() - 1));
  Eigen::VectorXd error(unknowns);
  for (std::size_t s = 1; s < truth.size(); ++s) {
    error.segment<6>(static_cast<Eigen::Index>(6 * (s - 1))) =
        LocalDifference(result.survey_from_station[s], truth[s]);
  }
  const double nees =
      error.dot(result.covariance.bottomRightCorner(unknowns, unknowns).llt().solve(error)) /
      static_cast<double>(unknowns);
  fmt::print(
      "status {} agreement {:.3f} variance factor {:.3f} (blocks {:.1f} m) weakest {:.2f} mm "
      "at station {}\n",
      static_cast<int>(result.status), result.agreement_factor, result.variance_factor,
      result.block_m, 1e3 * result.weakest.sigma_m, result.weakest.station);
  fmt::print("mean TE {:.3f} -> {:.3f} mm NEES/dof {:.3f}\n",
             1e3 * MeanDistance(input.survey_from_station, truth),
             1e3 * MeanDistance(result.survey_from_station, truth), nees);
  fmt::print("{:.1f} s, peak memory {:.0f} MB\n", seconds, PeakMemoryMb());
  std::fflush(stdout);
  CompareWithCeres(input, context);
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  const auto argument = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  backsight::Run(argument(1, 1), argument(2, 10), argument(3, 20));
  return 0;
}
