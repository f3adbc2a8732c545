#include "graph/subcell_finder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

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
  std::vector<std::size_t> counts(40);
  std::iota(counts.begin(), counts.end(), std::size_t{0});
  counts.insert(counts.end(), {511, 512, 513, 1100});  // runs end
  for (const std::size_t count : counts) {
    const VoxelLattice voxels{.edge_m = 0.1};
    VoxelLeaves leaves(voxels);
    std::vector<PointCluster> clusters;
    for (std::size_t i = 0; i < count; ++i) {
      const RigidTransform place = RandomTransform(random, 30.0);
      clusters.push_back({1.0, place.translation, Eigen::Matrix3d::Zero()});
      leaves.Add(voxels.Key(place.translation), clusters.back());
    }
    const RigidTransform motion = RandomTransform(random, 5.0);
    ForEachInstructionSet([&](const std::string& name) {
      for (const ClusterList& list : {ClusterList(leaves), ClusterList(clusters)}) {
        std::vector<std::uint64_t> found;
        SubcellFinder(motion, kRootEdge)
            .ForRuns(list, [&](std::size_t first, std::span<const std::uint64_t> keys) {
              ASSERT_EQ(first, found.size());
              found.insert(found.end(), keys.begin(), keys.end());
            });
        ASSERT_EQ(found.size(), count);
        for (std::size_t i = 0; i < count; ++i) {
          EXPECT_EQ(found[i], fine.Key(motion * list.Mean(i))) << name << i;
        }
      }
    });
  }
}

}  // namespace
}  // namespace backsight
