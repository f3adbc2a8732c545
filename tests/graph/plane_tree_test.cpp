#include "graph/plane_tree.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

constexpr double kRootEdge = 0.8;

PointCluster FlatCluster(const Eigen::Vector3d& mean) {
  return {20.0, mean, Eigen::Vector3d(8e-3, 8e-3, 1e-7).asDiagonal()};
}

/// Two flat pieces in every root cell of a cube of 24 a side: seven nodes each.
std::vector<PointCluster> PairsOfPieces() {
  std::vector<PointCluster> clusters;
  for (int x = -12; x < 12; ++x) {
    for (int y = -12; y < 12; ++y) {
      for (int z = -12; z < 12; ++z) {
        const Eigen::Vector3d corner = kRootEdge * Eigen::Vector3d(x, y, z);
        const double shift = 0.001 * ((x + 12) % 7);
        clusters.push_back(FlatCluster(corner + Eigen::Vector3d(0.14 + shift, 0.15, 0.25)));
        clusters.push_back(FlatCluster(corner + Eigen::Vector3d(0.63, 0.54 + shift, 0.25)));
      }
    }
  }
  return clusters;
}

TEST(PlaneTree, HoldsTensOfThousandsOfNodesWhereTheirCellsAre) {
  const std::vector<PointCluster> clusters = PairsOfPieces();
  PlaneSearchOptions options;
  options.root_edge_m = kRootEdge;
  const PlaneTree tree(clusters, {}, options);
  ASSERT_EQ(tree.roots(), clusters.size() / 2);
  const VoxelLattice subcells{.edge_m = kRootEdge / 8.0};
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const std::uint64_t key = subcells.Key(clusters[i].mean);
    const auto root = tree.FindRoot(OctreeCells::Root(key));
    ASSERT_TRUE(root.has_value());
    const PlaneTree::Node* node = &tree.Root(*root);
    const Eigen::Vector3d both = 0.5 * (clusters[i].mean + clusters[i ^ 1U].mean);
    EXPECT_LT((node->mean - both).norm(), 1e-9);
    for (int depth = 1; depth <= OctreeCells::kDepth; ++depth) {
      node = tree.Child(*node, OctreeCells::Octant(OctreeCells::Path(key), depth));
      ASSERT_NE(node, nullptr);
      EXPECT_LT((node->mean - clusters[i].mean).norm(), 1e-9);
      EXPECT_EQ(node->Local().count, clusters[i].count);
    }
  }
}

}  // namespace
}  // namespace backsight
