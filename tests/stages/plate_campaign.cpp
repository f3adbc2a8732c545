#include "tests/stages/plate_campaign.h"

#include "core/voxel_grid.h"
#include "tests/support/matchers.h"
#include "tests/support/synthetic_network.h"

namespace backsight {
namespace {

std::vector<RigidTransform> PlaceStations(Random& random, const PlateCampaignOptions& options) {
  std::vector<RigidTransform> poses;
  for (int s = 0; s < options.stations; ++s) {
    const double tilt = options.tilt_rad;
    const Eigen::Vector3d turn(random.Uniform(-tilt, tilt), random.Uniform(-tilt, tilt),
                               random.Uniform(-3.0, 3.0));
    poses.push_back(s == 0 ? RigidTransform{}
                           : RigidTransform{ExpSo3(turn), RandomPoint(random, 5.0)});
  }
  return poses;
}

StationModel Measure(Random& random, const PlateCampaignOptions& options, int station,
                     const RigidTransform& survey_from_station) {
  VoxelClusterer clusterer({.edge_m = 0.1});
  const RigidTransform station_from_survey = survey_from_station.Inverse();
  for (int plate = 0; plate < 6 * options.plates * options.plates; ++plate) {
    if (random.Uniform() < 0.3) continue;  // hidden
    const int side = plate % 6;
    const int column = plate / 6 % options.plates;
    const int row = plate / 6 / options.plates;
    for (int i = 0; i < options.points; ++i) {
      Eigen::Vector3d p;
      p[side / 2] = side % 2 == 0 ? -10.3 : 10.3;
      p[(side / 2 + 1) % 3] = 2.0 * (column - 4) + random.Uniform(0.0, 0.7);
      p[(side / 2 + 2) % 3] = 2.0 * (row - 4) + random.Uniform(0.0, 0.7);
      if (options.seen && !options.seen(station, p)) continue;
      if (options.measured) p = options.measured(station, p);
      clusterer.Add(station_from_survey * p + RandomNoise(random, options.noise_m));
    }
  }
  if (options.things) {
    for (const Eigen::Vector3d& p : options.things(random, survey_from_station.translation)) {
      clusterer.Add(station_from_survey * p + RandomNoise(random, options.noise_m));
    }
  }
  StationModel model;
  model.scanner_place = ScannerPlace::kGiven;
  model.leaves = clusterer.Finish();
  return model;
}

void LinkAll(Random& random, const PlateCampaignOptions& options, PlateCampaign* campaign) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(options.link_turn_sigma),
      Eigen::Vector3d::Constant(options.link_shift_sigma);
  const auto stations = static_cast<int>(campaign->truth.size());
  for (int t = 0; t < stations; ++t) {
    for (int s = t + 1; s < stations; ++s) {
      const RigidTransform target_from_source =
          campaign->truth[static_cast<std::size_t>(t)].Inverse() *
          campaign->truth[static_cast<std::size_t>(s)];
      Vector6d draw;
      for (int i = 0; i < 6; ++i) draw[i] = options.link_error * sigma[i] * random.Normal();
      campaign->input.links.push_back(
          {s, t, Retract(target_from_source, draw), sigma.cwiseAbs2().cwiseInverse().asDiagonal()});
    }
  }
}

}  // namespace

void SolveGraph(PlateCampaign* campaign) {
  const PoseGraphResult graph =
      SolveWithCovariance(static_cast<int>(campaign->truth.size()), campaign->input.links);
  campaign->input.survey_from_station = graph.survey_from_station;
  campaign->input.covariance = graph.covariance;
}

PlateCampaign MakePlateCampaign(std::uint64_t seed, const PlateCampaignOptions& options) {
  Random random(seed);
  PlateCampaign campaign;
  campaign.truth = PlaceStations(random, options);
  for (int s = 0; s < options.stations; ++s) {
    campaign.models.push_back(
        Measure(random, options, s, campaign.truth[static_cast<std::size_t>(s)]));
  }
  LinkAll(random, options, &campaign);
  SolveGraph(&campaign);
  return campaign;
}

NetworkRefinementResult Refine(PlateCampaign& campaign, const NetworkRefinementOptions& options,
                               int threads) {
  campaign.input.stations.clear();
  for (const StationModel& model : campaign.models) campaign.input.stations.push_back(&model);
  return RefineNetwork(campaign.input, options, ExecutionContext(threads));
}

}  // namespace backsight
