#include "stages/matching.h"

#include <algorithm>

#include "core/neighbors.h"
#include "stages/descriptor_distances.h"

namespace backsight {
void VisitOptions(OptionVisitor& visitor, MatchingOptions& options) {
  visitor.Integer("neighbors", options.neighbors, "1", 1, 50,
                  "a match is among the k nearest descriptors of both key points");
}

std::vector<DescriptorMatch> MatchDescriptors(std::span<const FpfhDescriptor> source,
                                              std::span<const FpfhDescriptor> target,
                                              const MatchingOptions& options) {
  if (source.empty() || target.empty()) return {};
  const auto k = static_cast<std::size_t>(options.neighbors);
  std::vector<DescriptorNeighbor> of_source(k * source.size());
  std::vector<DescriptorNeighbor> of_target(k * target.size());
  FindNearestDescriptors(source, target, k, of_source, of_target);

  std::vector<DescriptorMatch> matches;
  for (std::uint32_t s = 0; s < source.size(); ++s) {
    for (const auto& [distance, t] :
         std::span(of_source).subspan(k * s, std::min(k, target.size()))) {
      const auto back = std::span(of_target).subspan(k * t, std::min(k, source.size()));
      const bool mutual = std::any_of(back.begin(), back.end(),
                                      [&](const DescriptorNeighbor& n) { return n.index == s; });
      if (mutual) matches.push_back({s, t});
    }
  }
  return matches;
}

std::vector<Eigen::Vector3d> KeypointPositions(const StationModel& model,
                                               const StationFeatures& features) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(features.keypoints.size());
  for (const std::uint32_t leaf : features.keypoints) {
    positions.push_back(model.leaves.Mean(leaf));
  }
  return positions;
}

Correspondences MatchStations(const StationModel& source, const StationFeatures& source_features,
                              const StationModel& target, const StationFeatures& target_features,
                              const MatchingOptions& options) {
  const std::vector<Eigen::Vector3d> q = KeypointPositions(source, source_features);
  const std::vector<Eigen::Vector3d> p = KeypointPositions(target, target_features);
  Correspondences c;
  for (const DescriptorMatch& match :
       MatchDescriptors(source_features.descriptors, target_features.descriptors, options)) {
    c.Add(q[match.source], p[match.target], match.source, match.target);
  }
  return c;
}

Correspondences MatchPositions(const std::vector<Eigen::Vector3d>& source,
                               const std::vector<Eigen::Vector3d>& target,
                               const RigidTransform& transform, double radius_m) {
  Correspondences c;
  const NeighborSearch in_source(source);
  const NeighborSearch in_target(target);
  const RigidTransform inverse = transform.Inverse();
  for (std::uint32_t i = 0; i < source.size(); ++i) {
    const auto there = in_target.Nearest(transform * source[i], 1);
    if (there.empty() || there[0].distance_m > radius_m) continue;
    const std::uint32_t j = there[0].index;
    if (in_source.Nearest(inverse * target[j], 1)[0].index == i) c.Add(source[i], target[j], i, j);
  }
  return c;
}

}  // namespace backsight
