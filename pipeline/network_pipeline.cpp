#include "pipeline/network_pipeline.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "pipeline/candidate_links.h"

namespace backsight {
namespace {

/// Renumbers components of two or more stations by size (ties: first station); the rest get -1.
std::vector<int> RankComponents(const std::vector<int>& component) {
  const int count =
      component.empty() ? 0 : 1 + *std::max_element(component.begin(), component.end());
  std::vector<int> size(static_cast<std::size_t>(count), 0);
  for (const int c : component) ++size[static_cast<std::size_t>(c)];
  std::vector<int> order(size.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return size[static_cast<std::size_t>(a)] > size[static_cast<std::size_t>(b)];
  });
  std::vector<int> rank(size.size(), -1);
  for (std::size_t r = 0; r < order.size(); ++r) {
    const auto c = static_cast<std::size_t>(order[r]);
    if (size[c] >= 2) rank[c] = static_cast<int>(r);
  }
  std::vector<int> ranked;
  ranked.reserve(component.size());
  for (const int c : component) ranked.push_back(rank[static_cast<std::size_t>(c)]);
  return ranked;
}

/// A link for every candidate of the network.
std::vector<NetworkLink> MakeLinks(const std::vector<Pair>& pairs,
                                   const VerificationOptions& options, Network* network) {
  std::vector<NetworkLink> links;
  for (const CandidateLink& made : MakeCandidateLinks(pairs, options)) {
    links.push_back(made.link);
    NetworkCandidate candidate;
    candidate.pair = made.link.pair;
    candidate.candidate = made.candidate;
    network->candidates.push_back(candidate);
  }
  return links;
}

/// Solves with all links but the refuted ones, and tells every candidate its fate.
void Solve(int stations, const std::vector<NetworkLink>& links, const NetworkOptions& options,
           const ExecutionContext& context, Network* network) {
  std::vector<NetworkLink> given;
  std::vector<std::size_t> candidate_of;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (network->candidates[l].refuted) continue;
    given.push_back(links[l]);
    candidate_of.push_back(l);
  }
  network->solution = SolveNetwork(stations, given, options, [&] { context.CheckStop(); });
  for (std::size_t g = 0; g < given.size(); ++g) {
    NetworkCandidate& candidate = network->candidates[candidate_of[g]];
    candidate.fate = network->solution.fate[g];
    candidate.loop_controlled = network->solution.loop_controlled[g];
    candidate.covariance = network->solution.link_covariance[g];
  }
}

/// Looks across all bridges; true if one was refuted.
bool RefuteBridges(const std::vector<Surface>& surfaces, const std::vector<Station>& stations,
                   const std::vector<NetworkLink>& links, const PlacementCheckOptions& options,
                   const ExecutionContext& context, Network* network) {
  PlacementCheckInput input;
  input.survey_from_station = network->solution.poses.survey_from_station;
  input.component = network->solution.poses.component;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    input.stations.push_back(stations[s].usable() ? &surfaces[s] : nullptr);
    input.indices.push_back(stations[s].index.get());
  }
  std::vector<std::size_t> candidate_of;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (!network->candidates[l].used()) continue;
    input.links.push_back(
        {links[l].source, links[l].target, network->candidates[l].loop_controlled});
    candidate_of.push_back(l);
  }
  network->check = CheckPlacements(input, options, context);
  const int bridge = network->check.refuted_bridge;
  if (bridge < 0) return false;
  network->candidates[candidate_of[static_cast<std::size_t>(bridge)]].refuted = true;
  return true;
}

/// Input of the planar adjustment of one component; link indices become those within it.
NetworkRefinementInput MakeRefinementInput(const std::vector<Station>& stations,
                                           const std::vector<NetworkLink>& links,
                                           const NetworkOptions& options, const Network& network,
                                           const NetworkPart& part) {
  NetworkRefinementInput input;
  std::vector<int> place(stations.size(), -1);
  const PoseGraphResult& poses = network.solution.poses;
  for (const int station : part.stations) {
    const auto s = static_cast<std::size_t>(station);
    place[s] = static_cast<int>(input.stations.size());
    input.stations.push_back(&stations[s].model);
    input.normals.push_back(&stations[s].features.normals);
    input.survey_from_station.push_back(poses.survey_from_station[s]);
    input.covariance.push_back(poses.covariance[s]);
    input.level_sigma_rad.push_back(
        stations[s].spec.levelled
            ? std::optional(stations[s].spec.level_sigma_deg * std::numbers::pi / 180.0)
            : std::nullopt);
  }
  for (std::size_t l = 0; l < links.size(); ++l) {
    const int source = place[static_cast<std::size_t>(links[l].source)];
    const int target = place[static_cast<std::size_t>(links[l].target)];
    if (!network.candidates[l].used() || source < 0 || target < 0) continue;
    PoseGraphLink link;
    link.source = source;
    link.target = target;
    link.target_from_source = links[l].target_from_source;
    const double factor = network.solution.sigma_factor;
    link.information =
        (factor * factor * LinkCovariance(links[l], options)).ldlt().solve(Matrix6d::Identity());
    input.links.push_back(link);
  }
  return input;
}

/// Adjusts the planes of every component and hands poses and covariances over where it succeeded.
void RefineParts(const std::vector<Station>& stations, const std::vector<NetworkLink>& links,
                 const SurveyOptions& options, const ExecutionContext& context,
                 std::vector<RigidTransform>* poses, std::vector<Matrix6d>* covariance,
                 Network* network) {
  const int parts = 1 + *std::max_element(network->component.begin(), network->component.end());
  for (int p = 0; p < parts; ++p) {
    NetworkPart part;
    for (std::size_t s = 0; s < stations.size(); ++s) {
      if (network->component[s] == p) part.stations.push_back(static_cast<int>(s));
    }
    const NetworkRefinementInput input =
        MakeRefinementInput(stations, links, options.network, *network, part);
    part.links = static_cast<int>(input.links.size());
    if (options.refinement.enabled) {
      part.refinement = RefineNetwork(input, options.refinement, context);
    }
    if (part.refinement.status == NetworkRefinementResult::Status::kRefined) {
      for (std::size_t i = 0; i < part.stations.size(); ++i) {
        const auto s = static_cast<std::size_t>(part.stations[i]);
        const auto row = static_cast<Eigen::Index>(6 * i);
        (*poses)[s] = part.refinement.survey_from_station[i];
        (*covariance)[s] = part.refinement.covariance.block<6, 6>(row, row);
      }
    }
    network->parts.push_back(std::move(part));
  }
}

/// Covariances of the links at the poses that the planes gave.
void UpdateLinks(const std::vector<NetworkLink>& links, const std::vector<RigidTransform>& poses,
                 Network* network) {
  for (const NetworkPart& part : network->parts) {
    if (part.refinement.status != NetworkRefinementResult::Status::kRefined) continue;
    const auto place = [&](int station) {
      const auto found = std::lower_bound(part.stations.begin(), part.stations.end(), station);
      return found != part.stations.end() && *found == station
                 ? static_cast<int>(found - part.stations.begin())
                 : -1;
    };
    for (std::size_t l = 0; l < links.size(); ++l) {
      const int source = place(links[l].source);
      const int target = place(links[l].target);
      if (source < 0 || target < 0) continue;
      network->candidates[l].covariance =
          RelativeCovariance(part.refinement.covariance, source, target,
                             poses[static_cast<std::size_t>(links[l].target)]);
    }
  }
}

/// Of every motion, used or not, whose stations hang together.
void MeasureResiduals(const std::vector<NetworkLink>& links,
                      const std::vector<RigidTransform>& poses, const NetworkOptions& options,
                      Network* network) {
  const double factor = network->solution.sigma_factor;
  for (std::size_t l = 0; l < links.size(); ++l) {
    const auto source = static_cast<std::size_t>(links[l].source);
    const auto target = static_cast<std::size_t>(links[l].target);
    const int component = network->component[source];
    if (component < 0 || component != network->component[target]) continue;
    const double sigmas =
        ResidualInSigmas(links[l], poses[target].Inverse() * poses[source], options) / factor;
    if (std::isfinite(sigmas)) network->candidates[l].residual_sigmas = sigmas;
  }
}

/// From instrument frames to station frames, with the first station of each component as datum.
void SetStationPoses(const std::vector<Station>& stations,
                     const std::vector<RigidTransform>& survey_from_instrument,
                     const std::vector<Matrix6d>& covariance, Network* network) {
  const PoseGraphResult& poses = network->solution.poses;
  std::vector<int> first(stations.size(), -1);  // by component of the pose graph
  for (std::size_t s = 0; s < stations.size(); ++s) {
    int& datum = first[static_cast<std::size_t>(poses.component[s])];
    if (datum < 0) datum = static_cast<int>(s);
    const RigidTransform station_from_instrument =
        stations[static_cast<std::size_t>(datum)].model.StationFromInstrument();
    network->survey_from_station.push_back(station_from_instrument * survey_from_instrument[s] *
                                           stations[s].model.StationFromInstrument().Inverse());
    const Matrix6d adjoint = Adjoint(station_from_instrument);
    network->covariance.push_back(adjoint * covariance[s] * adjoint.transpose());
  }
}

/// A pair is reported by the motion that the network uses, otherwise by its best.
void ChooseReported(std::size_t pairs, Network* network) {
  network->reported.assign(pairs, -1);
  for (std::size_t l = 0; l < network->candidates.size(); ++l) {
    int& reported = network->reported[static_cast<std::size_t>(network->candidates[l].pair)];
    if (reported < 0 || network->candidates[l].used()) reported = static_cast<int>(l);
  }
}

}  // namespace

Network BuildNetwork(const std::vector<Station>& stations, const std::vector<Pair>& pairs,
                     const SurveyOptions& options, const ExecutionContext& context) {
  context.Progress("network", 0, 1);
  Network network;
  const std::vector<NetworkLink> links = MakeLinks(pairs, options.verification, &network);
  std::vector<Surface> surfaces;
  surfaces.reserve(stations.size());
  for (const Station& station : stations) {
    surfaces.push_back(station.surface());
  }
  do {
    context.CheckStop();
    Solve(static_cast<int>(stations.size()), links, options.network, context, &network);
  } while (RefuteBridges(surfaces, stations, links, options.placement_check, context, &network));

  network.component = RankComponents(network.solution.poses.component);
  std::vector<RigidTransform> poses = network.solution.poses.survey_from_station;
  std::vector<Matrix6d> covariance = network.solution.poses.covariance;
  RefineParts(stations, links, options, context, &poses, &covariance, &network);
  UpdateLinks(links, poses, &network);
  MeasureResiduals(links, poses, options.network, &network);
  SetStationPoses(stations, poses, covariance, &network);
  ChooseReported(pairs.size(), &network);
  context.Progress("network", 1, 1);
  return network;
}

}  // namespace backsight
