#include "graph/common_cells.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/random.h"

namespace backsight {
namespace {

std::vector<PointCluster> RandomClusters(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<PointCluster> clusters(count);
  for (PointCluster& cluster : clusters) {
    cluster.count = 1.0;
    cluster.mean = {random.Uniform(-5.0, 5.0), random.Uniform(-5.0, 5.0),
                    random.Uniform(-1.0, 1.0)};
  }
  return clusters;
}

TEST(FindCommonCells, GathersWhatTwoOrMoreStationsSee) {
  const VoxelLattice lattice{.edge_m = 0.8};
  for (const std::size_t stations : {1U, 2U, 3U, 5U}) {
    std::vector<std::vector<PointCluster>> clusters;
    std::vector<RigidTransform> poses;
    for (std::size_t s = 0; s < stations; ++s) {
      clusters.push_back(RandomClusters(10 * stations + s, 300 + 100 * s));
      poses.push_back({ExpSo3({0.0, 0.1, 0.3 * static_cast<double>(s)}),
                       Eigen::Vector3d(static_cast<double>(s), 0.5, 0.0)});
    }
    std::map<std::uint64_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>> cells;
    for (std::uint32_t s = 0; s < stations; ++s) {
      for (std::uint32_t i = 0; i < clusters[s].size(); ++i) {
        cells[lattice.Key(poses[s] * clusters[s][i].mean)].emplace_back(s, i);
      }
    }
    std::erase_if(cells, [](const auto& cell) {
      return cell.second.front().first == cell.second.back().first;
    });

    const std::vector<ClusterList> lists(clusters.begin(), clusters.end());
    const ExecutionContext threads(0);
    for (const ExecutionContext* context :
         {static_cast<const ExecutionContext*>(nullptr), &threads}) {
      const CommonCells common = FindCommonCells(lists, poses, lattice, context);
      ASSERT_EQ(common.keys.size(), cells.size());
      std::size_t c = 0;
      for (const auto& [key, entries] : cells) {
        EXPECT_EQ(common.keys[c], key);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
        for (const CellEntry& entry : common.Cell(c))
          found.emplace_back(entry.station, entry.cluster);
        EXPECT_EQ(found, entries);
        ++c;
      }
    }
  }
}

}  // namespace
}  // namespace backsight
