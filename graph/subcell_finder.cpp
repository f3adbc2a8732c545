#include "graph/subcell_finder.h"

#include <cmath>

#include "graph/octree_cells.h"
#include "graph/subcell_kernels.h"

namespace backsight {

SubcellFinder::SubcellFinder(const ClusterList& clusters) : keys_(clusters.size()) {
  if (const auto means = clusters.means()) {
    means_ = *means;
    return;
  }
  copied_.reserve(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) copied_.push_back(clusters.Mean(i));
  means_ = copied_;
}

void SubcellFinder::Find(const RigidTransform& lattice_from_clusters, double root_edge_m) {
  if (means_.empty()) return;
  LatticeMotion motion;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      motion.rotation[static_cast<std::size_t>(3 * row + column)] =
          lattice_from_clusters.rotation(row, column);
    }
    motion.translation[static_cast<std::size_t>(row)] = lattice_from_clusters.translation[row];
  }
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  FindSubcells(means_.front().data(), means_.size(), motion,
               std::ldexp(root_edge_m, -OctreeCells::kDepth), keys_.data());
}

}  // namespace backsight
