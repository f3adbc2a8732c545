#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/random.h"
#include "io/scene_file.h"
#include "stages/ingest.h"
#include "stages/leaf_grid.h"
#include "stages/network_refinement.h"
#include "stages/normal_orientation.h"
#include "stages/normals.h"
#include "stages/simulation/campaign.h"
#include "tests/support/synthetic_network.h"

// Do the stated uncertainties come true? Simulates scenes in process, refines the network from
// disturbed poses, and prints the normalised estimation error squared per degree of freedom:
//   network_refinement_nees FIRST_SEED SEEDS SCENE.yaml...

namespace backsight {
namespace {

/// A simulated scan as a reader of scan files would hand it out.
class SimulatedScan : public ScanReader {
 public:
  explicit SimulatedScan(StationScan scan) : scan_(std::move(scan)) {}
  const ScanInfo& info() const override { return info_; }
  bool Next(PointChunk& chunk) override {
    chunk.Clear();
    if (done_) return false;
    for (std::size_t i = 0; i < scan_.grid.size(); ++i) {
      if (scan_.grid.x[i] == 0.0 && scan_.grid.y[i] == 0.0 && scan_.grid.z[i] == 0.0) continue;
      chunk.x.push_back(scan_.grid.x[i]);
      chunk.y.push_back(scan_.grid.y[i]);
      chunk.z.push_back(scan_.grid.z[i]);
    }
    tally_.records = tally_.points = chunk.size();
    done_ = true;
    return true;
  }
  const ScanTally& tally() const override { return tally_; }

 private:
  StationScan scan_;
  ScanInfo info_;
  ScanTally tally_;
  bool done_ = false;
};

/// Links of 3 mm and 0.02 deg between stations within reach of each other.
std::vector<PoseGraphLink> MakeLinks(const Campaign& campaign, Random& random) {
  constexpr double kReach = 40.0;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.02 * std::numbers::pi / 180.0),
      Eigen::Vector3d::Constant(0.003);
  std::vector<PoseGraphLink> links;
  for (std::size_t t = 0; t < campaign.stations.size(); ++t) {
    for (std::size_t s = t + 1; s < campaign.stations.size(); ++s) {
      const RigidTransform truth = campaign.stations[t].survey_from_station.Inverse() *
                                   campaign.stations[s].survey_from_station;
      if (truth.translation.norm() > kReach) continue;
      Vector6d draw;
      for (int i = 0; i < 6; ++i) draw[i] = sigma[i] * random.Normal();
      PoseGraphLink link;
      link.source = static_cast<int>(s);
      link.target = static_cast<int>(t);
      link.target_from_source = Retract(truth, draw);
      link.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
      links.push_back(link);
    }
  }
  return links;
}

double Nees(const std::vector<RigidTransform>& poses, const Campaign& campaign,
            const Eigen::MatrixXd& covariance, double* mean_te_m, double* mean_re_rad) {
  const auto rows = static_cast<Eigen::Index>(6 * (poses.size() - 1));
  Eigen::VectorXd error(rows);
  for (std::size_t s = 1; s < poses.size(); ++s) {
    const RigidTransform& truth = campaign.stations[s].survey_from_station;
    error.segment<6>(static_cast<Eigen::Index>(6 * (s - 1))) = LocalDifference(poses[s], truth);
    const auto others = static_cast<double>(poses.size() - 1);
    *mean_te_m += (poses[s].translation - truth.translation).norm() / others;
    *mean_re_rad += RotationAngle(poses[s].rotation, truth.rotation) / others;
  }
  return error.dot(covariance.bottomRightCorner(rows, rows).ldlt().solve(error)) /
         static_cast<double>(rows);
}

double RunOne(const std::string& path, std::uint64_t seed, const ExecutionContext& context) {
  Scene scene = ReadScene(path);
  scene.seed = seed;
  const Campaign campaign = PrepareCampaign(scene);
  std::vector<StationModel> models;
  for (std::size_t s = 0; s < campaign.stations.size(); ++s) {
    SimulatedScan scan(SimulateStation(campaign, s, context));
    models.push_back(IngestScan(campaign.stations[s].id, scan, std::nullopt, {}, context).model);
  }
  Random random(seed);
  NetworkRefinementInput input;
  std::vector<std::vector<Eigen::Vector3f>> normals;
  for (const StationModel& model : models) {
    const double radius_m = 3.0 * model.resolution_m();
    std::vector<Eigen::Vector3f> positions;
    for (const Eigen::Vector3d& mean : model.leaves.means()) {
      positions.push_back(mean.cast<float>());
    }
    normals.push_back(EstimateNormals(LeafGrid(positions, radius_m), radius_m, context));
    OrientNormals(model, context, &normals.back());
  }
  for (std::size_t s = 0; s < models.size(); ++s) {
    input.stations.push_back(&models[s]);
    input.normals.push_back(&normals[s]);
  }
  input.links = MakeLinks(campaign, random);
  const PoseGraphResult graph = SolveWithCovariance(static_cast<int>(models.size()), input.links);
  input.survey_from_station = graph.survey_from_station;
  input.covariance = graph.covariance;
  const NetworkRefinementResult result = RefineNetwork(input, {}, context);
  double te = 0.0;
  double re = 0.0;
  const double nees = Nees(result.survey_from_station, campaign, result.covariance, &te, &re);
  int iterations = 0;
  for (const RefinementRound& round : result.rounds) iterations += round.iterations;
  double before = 0.0;
  double after = 0.0;
  for (const HeldOutPair& pair : result.held_out) {
    before += pair.rms_before / static_cast<double>(result.held_out.size());
    after += pair.rms_after / static_cast<double>(result.held_out.size());
  }
  fmt::print(
      "{:12} seed {:4} status {} planes {:6} rounds {} its {:3} sigma0 {:.2f} mm agree {:.3f} vf "
      "{:.3f} (block {:.1f} m) TE {:.3f} mm RE {:.5f} deg held-out {:.2f} -> {:.2f} mm weakest "
      "{:.3f} mm NEES/dof {:.3f}\n",
      scene.name, seed, static_cast<int>(result.status), result.planes, result.rounds.size(),
      iterations, 1e3 * result.sigma0_m, result.agreement_factor, result.variance_factor,
      result.block_m, 1e3 * te, re * 180.0 / std::numbers::pi, 1e3 * before, 1e3 * after,
      1e3 * result.weakest.sigma_m, nees);
  std::fflush(stdout);
  return nees;
}

}  // namespace
}  // namespace backsight

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: network_refinement_nees FIRST_SEED SEEDS SCENE.yaml...\n");
    return 2;
  }
  const auto first = std::strtoull(argv[1], nullptr, 10);
  const auto seeds = std::strtoull(argv[2], nullptr, 10);
  const backsight::ExecutionContext context(1);
  for (int i = 3; i < argc; ++i) {
    double sum = 0.0;
    for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
      sum += backsight::RunOne(argv[i], seed, context);
    }
    fmt::print("{}: mean NEES/dof {:.3f}\n", argv[i], sum / static_cast<double>(seeds));
  }
  return 0;
}
