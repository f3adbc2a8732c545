#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/rigid_transform.h"
#include "graph/cluster_list.h"

namespace backsight {

/// The subcells of a lattice (OctreeCells) that clusters' means lie in under one motion.
class SubcellFinder {
 public:
  SubcellFinder(const RigidTransform& lattice_from_clusters, double root_edge_m)
      : lattice_from_clusters_(lattice_from_clusters), root_edge_m_(root_edge_m) {}

  /// Calls `use(first, keys)` for one run of clusters after another, the first of each and its
  /// subcells' keys, so that nobody needs to keep all keys.
  template <class Use>
  void ForRuns(const ClusterList& clusters, Use use) const {
    std::array<std::uint64_t, kRun> keys;
    for (std::size_t first = 0; first < clusters.size(); first += kRun) {
      const auto run = std::span(keys).first(std::min(kRun, clusters.size() - first));
      Find(clusters, first, run);
      use(first, std::span<const std::uint64_t>(run));
    }
  }

 private:
  static constexpr std::size_t kRun = 512;
  void Find(const ClusterList& clusters, std::size_t first, std::span<std::uint64_t> keys) const;

  RigidTransform lattice_from_clusters_;
  double root_edge_m_;
};

}  // namespace backsight
