#include "graph/station_placement.h"

#include <algorithm>

namespace backsight {
namespace {

/// Where the link puts `station`, given the other end.
RigidTransform PlacedBy(const PoseGraphLink& link, int station,
                        std::span<const RigidTransform> poses) {
  if (station == link.source) {
    return poses[static_cast<std::size_t>(link.target)] * link.target_from_source;
  }
  return poses[static_cast<std::size_t>(link.source)] * link.target_from_source.Inverse();
}

bool MoveStation(const std::vector<PoseGraphLink>& own_links, int station, double limit,
                 std::vector<RigidTransform>* poses) {
  RigidTransform& pose = (*poses)[static_cast<std::size_t>(station)];
  RigidTransform best = pose;
  const double before = TruncatedCost(own_links, *poses, limit);
  double best_cost = before;
  for (const PoseGraphLink& link : own_links) {
    pose = PlacedBy(link, station, *poses);
    const double cost = TruncatedCost(own_links, *poses, limit);
    if (cost < best_cost) {
      best_cost = cost;
      best = pose;
    }
  }
  pose = best;
  // At least one more link agrees; anything less is for the least-squares solution.
  return best_cost < before - 0.5 * limit;
}

}  // namespace

double SquaredError(const PoseGraphLink& link, std::span<const RigidTransform> poses) {
  const Vector6d r = LinkResidual(link, poses[static_cast<std::size_t>(link.source)],
                                  poses[static_cast<std::size_t>(link.target)]);
  return r.dot(link.information * r);
}

double TruncatedCost(std::span<const PoseGraphLink> links, std::span<const RigidTransform> poses,
                     double limit) {
  double cost = 0.0;
  for (const PoseGraphLink& link : links) cost += std::min(SquaredError(link, poses), limit);
  return cost;
}

void MoveStationsToConsensus(std::span<const PoseGraphLink> links,
                             const std::vector<int>& component, double limit,
                             std::vector<RigidTransform>* poses) {
  std::vector<std::vector<PoseGraphLink>> links_of(poses->size());
  for (const PoseGraphLink& link : links) {
    links_of[static_cast<std::size_t>(link.source)].push_back(link);
    links_of[static_cast<std::size_t>(link.target)].push_back(link);
  }
  constexpr int kMaxPasses = 20;
  bool moved = true;
  for (int pass = 0; pass < kMaxPasses && moved; ++pass) {
    moved = false;
    for (std::size_t s = 0; s < poses->size(); ++s) {
      moved |= MoveStation(links_of[s], static_cast<int>(s), limit, poses);
    }
  }
  std::vector<RigidTransform> component_from_survey;
  for (std::size_t s = 0; s < poses->size(); ++s) {
    const auto c = static_cast<std::size_t>(component[s]);
    if (c == component_from_survey.size()) component_from_survey.push_back((*poses)[s].Inverse());
    (*poses)[s] = component_from_survey[c] * (*poses)[s];
  }
}

}  // namespace backsight
