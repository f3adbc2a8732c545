#include <fmt/format.h>
#include <sys/resource.h>

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/random.h"
#include "stages/network_refinement.h"
#include "tests/support/synthetic_network.h"

// Planar adjustment over 200 stations of a synthetic town with more than 100,000 planes:
//   network_refinement_benchmark [THREADS]

namespace backsight {
namespace {

constexpr int kRows = 10;
constexpr int kColumns = 20;
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

std::vector<RigidTransform> PlaceStations(Random& random) {
  std::vector<RigidTransform> poses;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
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

void Run(int threads) {
  const ExecutionContext context(threads);
  Random random(1);
  const std::vector<RigidTransform> truth = PlaceStations(random);
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
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  for (const RefinementRound& round : result.rounds) {
    fmt::print(
        "planes {} observations {} iterations {} anderson {} start {} cost {:.6g} -> {:.6g} "
        "largest move {:.3f} mm\n",
        round.planes, round.observations, round.iterations, round.anderson_accepted,
        round.anderson_start, round.cost_before, round.cost_after, 1e3 * round.largest_move_m);
  }
  const auto rows = static_cast<Eigen::Index>(6 * (truth.size() - 1));
  Eigen::VectorXd error(rows);
  for (std::size_t s = 1; s < truth.size(); ++s) {
    error.segment<6>(static_cast<Eigen::Index>(6 * (s - 1))) =
        LocalDifference(result.survey_from_station[s], truth[s]);
  }
  const double nees =
      error.dot(result.covariance.bottomRightCorner(rows, rows).llt().solve(error)) /
      static_cast<double>(rows);
  fmt::print(
      "status {} agreement {:.3f} variance factor {:.3f} (blocks {:.1f} m) weakest {:.2f} mm "
      "at station {}\n",
      static_cast<int>(result.status), result.agreement_factor, result.variance_factor,
      result.block_m, 1e3 * result.weakest.sigma_m, result.weakest.station);
  fmt::print("mean TE {:.3f} -> {:.3f} mm NEES/dof {:.3f}\n",
             1e3 * MeanDistance(input.survey_from_station, truth),
             1e3 * MeanDistance(result.survey_from_station, truth), nees);
  fmt::print("{:.1f} s, peak memory {:.0f} MB\n", seconds.count(), PeakMemoryMb());
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  backsight::Run(argc > 1 ? std::atoi(argv[1]) : 1);
  return 0;
}
