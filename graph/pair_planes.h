#pragma once

#include <vector>

#include "graph/plane_segmentation.h"
#include "graph/plane_tree.h"
#include "graph/subcell_finder.h"

namespace backsight {

/// FindPlanes for two stations, the first of which a PlaneTree knows: for pairs, whose first
/// station takes part in many, and which search again as the second one moves. Keeps its memory
/// from search to search: 16 bytes for each cluster of the second.
class PairPlaneSearch {
 public:
  /// Both must outlive it; the second station's clusters are in its own frame.
  PairPlaneSearch(const PlaneTree& first, const ClusterList& second);

  /// The planes of FindPlanes(first, second) but for what rounding decides: stations 0 and 1, poses
  /// into the tree's lattice. `options` agree with the tree's but for the last two, which concern
  /// both stations. Time O(n) for n clusters of the second.
  std::vector<PlaneAssociation> Find(const RigidTransform& lattice_from_second,
                                     const PlaneSearchOptions& options);

 private:
  class Descent;
  void FindRoots(const SubcellFinder& subcells);
  void SortIntoRoots();

  const PlaneTree& first_;
  ClusterList second_;
  // By cluster: its subcell in the last search, and its root's place among the first's.
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> places_;
  std::vector<std::uint32_t> by_root_;  // the clusters; those of one root ascend
  std::vector<std::uint32_t> begins_;   // of each root's in it
  std::vector<PathEntry> cell_;
};

}  // namespace backsight
