#pragma once

#include <span>

#include "core/option_visitor.h"
#include "core/rigid_transform.h"
#include "graph/correspondences.h"
#include "stages/station_model.h"

namespace backsight {

struct MatchingOptions {
  int neighbors = 5;  ///< k
};
void VisitOptions(OptionVisitor& visitor, MatchingOptions& options);

/// A pair of descriptors, each among the other's k nearest.
struct DescriptorMatch {
  std::uint32_t source = 0;
  std::uint32_t target = 0;
};

/// Mutual k nearest neighbours by Euclidean distance, exact; sorted by source, then distance.
/// Equal distances go to the lower index. Time O(n_source * n_target) as blocked matrix products.
std::vector<DescriptorMatch> MatchDescriptors(std::span<const FpfhDescriptor> source,
                                              std::span<const FpfhDescriptor> target,
                                              const MatchingOptions& options);

/// Positions of a station's key points, instrument frame.
std::vector<Eigen::Vector3d> KeypointPositions(const StationModel& model,
                                               const StationFeatures& features);

/// Putative correspondences C1 between the key points of two stations.
Correspondences MatchStations(const StationModel& source, const StationFeatures& source_features,
                              const StationModel& target, const StationFeatures& target_features,
                              const MatchingOptions& options);

/// Key points that lie closest to each other, both ways, within `radius_m` once `transform` (target
/// from source) is known: what descriptors alone could not tell. Ids are the indices.
Correspondences MatchPositions(const std::vector<Eigen::Vector3d>& source,
                               const std::vector<Eigen::Vector3d>& target,
                               const RigidTransform& transform, double radius_m);

}  // namespace backsight
