#include "graph/subcell_finder.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/voxel_grid.h"
#include "graph/octree_cells.h"
#include "tests/support/instruction_sets.h"
#include "tests/support/matchers.h"

namespace backsight {
namespace {

TEST(SubcellFinder, FindsTheCellsOfTheLatticeForAnyNumberOfClusters) {
  constexpr double kRootEdge = 1.3;
  const VoxelLattice fine{.edge_m = kRootEdge / 8.0};
  Random random(4);
  for (std::size_t count = 0; count < 40; ++count) {
    VoxelLeaves leaves;
    std::vector<PointCluster> clusters;
    for (std::size_t i = 0; i < count; ++i) {
      const RigidTransform place = RandomTransform(random, 30.0);
      clusters.push_back({1.0, place.translation, Eigen::Matrix3d::Zero()});
      leaves.Add(i, clusters.back());
    }
    const RigidTransform motion = RandomTransform(random, 5.0);
    ForEachInstructionSet([&](const std::string& name) {
      for (const ClusterList& list : {ClusterList(leaves), ClusterList(clusters)}) {
        SubcellFinder subcells(list);
        subcells.Find(motion, kRootEdge);
        ASSERT_EQ(subcells.size(), count);
        for (std::size_t i = 0; i < count; ++i) {
          EXPECT_EQ(subcells.keys()[i], fine.Key(motion * clusters[i].mean)) << name << i;
        }
      }
    });
  }
}

}  // namespace
}  // namespace backsight
