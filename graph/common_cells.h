#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/execution.h"
#include "core/rigid_transform.h"
#include "core/voxel_grid.h"
#include "graph/cluster_list.h"

namespace backsight {

/// A cluster's place among all, as light as it can be: there may be hundreds of millions.
struct CellEntry {
  std::uint32_t station;
  std::uint32_t cluster;
};

/// The clusters in lattice cells that two or more stations see.
struct CommonCells {
  std::vector<std::uint64_t> keys;  ///< of the cells, ascending
  std::vector<std::size_t> begins;  ///< of each cell's entries, and the end of all
  std::vector<CellEntry> entries;   ///< by cell, station and cluster

  std::span<const CellEntry> Cell(std::size_t c) const {
    return std::span(entries).subspan(begins[c], begins[c + 1] - begins[c]);
  }
};

/// `poses[s]` moves station s's clusters into the lattice's frame; a cluster belongs to the cell
/// its mean lies in. `context` (may be null: one thread) changes the time only. Time O(clusters);
/// memory 4 bytes per cluster and 8 per entry.
CommonCells FindCommonCells(std::span<const ClusterList> clusters,
                            std::span<const RigidTransform> poses, const VoxelLattice& lattice,
                            const ExecutionContext* context);

}  // namespace backsight
