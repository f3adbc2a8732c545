#include "pipeline/network_pipeline.h"

#include <algorithm>
#include <numeric>

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

/// From instrument frames to station frames, with the first station of each component as datum.
void SetStationPoses(const std::vector<Station>& stations, Network* network) {
  const PoseGraphResult& poses = network->solution.poses;
  std::vector<int> first(stations.size(), -1);  // by component of the pose graph
  for (std::size_t s = 0; s < stations.size(); ++s) {
    int& datum = first[static_cast<std::size_t>(poses.component[s])];
    if (datum < 0) datum = static_cast<int>(s);
    const RigidTransform survey_from_instrument =
        stations[static_cast<std::size_t>(datum)].model.StationFromInstrument();
    network->survey_from_station.push_back(survey_from_instrument * poses.survey_from_station[s] *
                                           stations[s].model.StationFromInstrument().Inverse());
    const Matrix6d adjoint = Adjoint(survey_from_instrument);
    network->covariance.push_back(adjoint * poses.covariance[s] * adjoint.transpose());
  }
}

}  // namespace

Network BuildNetwork(const std::vector<Station>& stations, const std::vector<Pair>& pairs,
                     const NetworkOptions& options) {
  Network network;
  std::vector<NetworkLink> links;
  for (const Pair& pair : pairs) {
    network.link_of_pair.push_back(pair.accepted() ? static_cast<int>(links.size()) : -1);
    if (!pair.accepted()) continue;
    const PairCandidate& best = *pair.best();
    links.push_back({pair.source, pair.target, best.fine.target_from_source, best.fine.information,
                     (1 + best.fine.planes) * best.verification.overlap});
  }
  network.solution = SolveNetwork(static_cast<int>(stations.size()), links, options);
  network.component = RankComponents(network.solution.poses.component);
  SetStationPoses(stations, &network);
  return network;
}

}  // namespace backsight
