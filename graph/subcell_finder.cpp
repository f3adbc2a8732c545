#include "graph/subcell_finder.h"

#include <cmath>

#include "graph/octree_cells.h"
#include "graph/subcell_kernels.h"

namespace backsight {

/// The keys of as many clusters from `first` as there is room for.
void SubcellFinder::Find(const ClusterList& clusters, std::size_t first,
                         std::span<std::uint64_t> keys) const {
  std::array<Eigen::Vector3d, kRun> means;  // one after another
  for (std::size_t i = 0; i < keys.size(); ++i) means[i] = clusters.Mean(first + i);
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  FindSubcells(means.front().data(), keys.size(), KernelMotion(lattice_from_clusters_),
               std::ldexp(root_edge_m_, -OctreeCells::kDepth), keys.data());
}

}  // namespace backsight
