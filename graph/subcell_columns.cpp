#include "graph/subcell_columns.h"

#include <cmath>

#include "graph/octree_cells.h"
#include "graph/subcell_kernels.h"

namespace backsight {

SubcellColumns::SubcellColumns(const ClusterList& clusters)
    : size_(clusters.size()), keys_(clusters.size() + kSubcellPadding) {
  for (std::vector<double>& column : means_) column.resize(size_ + kSubcellPadding);
  for (std::size_t i = 0; i < size_; ++i) {
    const Eigen::Vector3d& mean = clusters.Mean(i);
    means_[0][i] = mean.x();
    means_[1][i] = mean.y();
    means_[2][i] = mean.z();
  }
}

void SubcellColumns::Find(const RigidTransform& lattice_from_clusters, double root_edge_m) {
  LatticeMotion motion;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      motion.rotation[static_cast<std::size_t>(3 * row + column)] =
          lattice_from_clusters.rotation(row, column);
    }
    motion.translation[static_cast<std::size_t>(row)] = lattice_from_clusters.translation[row];
  }
  FindSubcells({means_[0].data(), means_[1].data(), means_[2].data()}, size_, motion,
               std::ldexp(root_edge_m, -OctreeCells::kDepth), keys_.data());
}

}  // namespace backsight
