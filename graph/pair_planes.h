#pragma once

#include <vector>

#include "graph/plane_segmentation.h"
#include "graph/plane_tree.h"
#include "graph/subcell_finder.h"

namespace backsight {

/// FindPlanes for two stations, the first of which a PlaneTree knows: for pairs, whose first
/// station takes part in many, and which search again as the second one moves. Keeps its memory
/// from search to search.
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
  void FindRoots();
  void SortByPath();
  void SortIntoRoots();

  const PlaneTree& first_;
  ClusterList second_;
  SubcellFinder subcells_;
  std::vector<std::uint64_t> roots_;   // of each cluster in the last search
  std::vector<std::uint32_t> places_;  // of each cluster's root among the first's
  std::vector<std::uint32_t> begins_;  // of each root's entries
  std::vector<PathEntry> by_path_;     // by path and cluster
  std::vector<PathEntry> entries_;     // by root, path and cluster
};

}  // namespace backsight
