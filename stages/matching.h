#pragma once

#include <span>

#include "core/option_visitor.h"
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

/// Putative correspondences C1 between the key points of two stations.
Correspondences MatchStations(const StationModel& source, const StationFeatures& source_features,
                              const StationModel& target, const StationFeatures& target_features,
                              const MatchingOptions& options);

}  // namespace backsight
