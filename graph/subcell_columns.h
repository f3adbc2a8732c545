#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/rigid_transform.h"
#include "graph/cluster_list.h"

namespace backsight {

/// Means of clusters by coordinate, and the subcells of a lattice (OctreeCells) that they lie in
/// under one motion after another. Memory 32 bytes for each cluster.
class SubcellColumns {
 public:
  explicit SubcellColumns(const ClusterList& clusters);

  std::size_t size() const { return size_; }
  /// Sets `keys` to the subcells of the lattice of root cells with edge `root_edge_m`.
  void Find(const RigidTransform& lattice_from_clusters, double root_edge_m);
  const std::vector<std::uint64_t>& keys() const { return keys_; }  ///< padded

 private:
  std::size_t size_;
  std::array<std::vector<double>, 3> means_;
  std::vector<std::uint64_t> keys_;
};

}  // namespace backsight
